// SPDX-License-Identifier: Apache-2.0
// The layouts of recordings, a row each: how one is read, and which keys its table has.
#pragma once

#include <string>
#include <vector>

#include "pipeline/recording/read_sequence.h"

namespace nightmap {

struct Layout {
  std::string name;
  // Lists the pictures, with times that do not yet include time_offset_s.
  RawSequence (*read)(const SequenceFolder& folder);
  std::vector<std::string> required = {};  // keys of [[sequence]] or [[query]] beside `layout`
  std::vector<std::string> own = {};       // keys that layouts without them refuse
  std::vector<std::string> refused = {};   // keys that others have
  // In a list, in a unit that the user may state. Otherwise times are counted, in seconds.
  bool lists_times = false;
  // Otherwise single pictures: without times and depth, anywhere, to be located only.
  bool is_recording = true;
};

const std::vector<Layout>& Layouts();
// Throws UsageError on a name of none.
const Layout& LayoutOf(const std::string& name);

}  // namespace nightmap
