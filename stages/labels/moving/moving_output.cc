// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/moving_output.h"

#include <algorithm>

#include "pipeline/io/frame_reader.h"

namespace nightmap {

std::vector<PackedMask> MasksOf(const MovingResult& result) {
  std::vector<PackedMask> masks;
  for (const auto& mask : result.masks) {
    if (mask) masks.push_back(*mask);
  }
  return masks;
}

std::vector<FrameRecord> FramesWithMasks(const std::vector<FrameRecord>& frames,
                                         const MovingResult& result,
                                         const std::string& file) {
  std::vector<FrameRecord> with_masks = frames;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    with_masks[i].others.erase(kMaskChannel);  // what labels say alone
    if (result.masks[i]) with_masks[i].others[kMaskChannel] = {file, HashOf(*result.masks[i])};
  }
  return with_masks;
}

nlohmann::json Summarize(const MovingResult& result) {
  return {{"num_frames", result.masks.size()},
          {"num_pairs", result.num_pairs},
          {"num_pairs_without_motion", result.num_pairs_without_motion},
          {"num_frames_mostly_moving",
           std::ranges::count_if(result.moving_shares, [](double share) { return share > 0.5; })},
          {"moving_shares", result.moving_shares}};
}

}  // namespace nightmap
