// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/layouts.h"

#include <algorithm>

#include "pipeline/base/error.h"

namespace nightmap {

const std::vector<Layout>& Layouts() {
  static const std::vector<Layout> layouts = {
      {.name = "tum", .read = ReadTumFolder, .required = {"folder", "camera"}, .lists_times = true},
      {.name = "seven_scenes", .read = ReadSevenScenesFolder, .required = {"folder", "camera"}},
      {.name = "video",
       .read = ReadVideoFolder,
       .required = {"folder", "camera", "video"},
       .own = {"video", "depth_folder"},
       .refused = {"label_folder", "moving_folder"}},
      {.name = "pictures",
       .read = ReadPictures,
       .required = {"pictures"},
       .own = {"pictures", "horizontal_fov_deg"},
       .refused = {"folder",
                   "frame_rate_hz",
                   "max_association_gap_s",
                   "time_unit",
                   "time_offset_s",
                   "depth",
                   "label_folder",
                   "moving_folder"},
       .lists_times = true,
       .is_recording = false}};
  return layouts;
}

std::vector<std::string> NamesOfLayouts() {
  std::vector<std::string> names;
  for (const Layout& layout : Layouts()) names.push_back(layout.name);
  return names;
}

const Layout& LayoutOf(const std::string& name) {
  const auto found = std::ranges::find(Layouts(), name, &Layout::name);
  if (found == Layouts().end()) throw UsageError("unknown layout \"{}\"", name);
  return *found;
}

}  // namespace nightmap
