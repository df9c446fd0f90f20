// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/ghosts/ghosts_output.h"

#include <algorithm>
#include <map>

#include "pipeline/base/files.h"
#include "pipeline/io/frame_reader.h"

namespace nightmap {

void WriteGhosts(const GhostsResult& result,
                 std::vector<FrameRecord> frames,
                 StageContext& context) {
  std::vector<PackedMask> masks;
  for (const auto& mask : result.masks) {
    if (mask) masks.push_back(*mask);
  }
  std::ranges::sort(masks, {}, &PackedMask::time_ns);
  WriteMasks(context.Output("masks"), masks, context.ConfigToml());
  std::map<std::int64_t, const PackedMask*> by_time;
  for (const PackedMask& mask : masks) by_time[mask.time_ns] = &mask;
  const std::string file = context.FinalPath("masks").filename().string();
  for (FrameRecord& frame : frames) {
    const auto mask = by_time.find(frame.time_ns);
    frame.others.erase(kMaskChannel);
    if (mask != by_time.end()) frame.others[kMaskChannel] = {file, HashOf(*mask->second)};
  }
  WriteFile(context.Output("frames"), FramesToCsv(frames));
}

}  // namespace nightmap
