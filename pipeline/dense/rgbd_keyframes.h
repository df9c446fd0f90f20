// SPDX-License-Identifier: Apache-2.0
// The keyframes of a finished trajectory with their pixels, for the stages that fuse depth.
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/parallel.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/frame_reader.h"
#include "pipeline/program/stage_context.h"

namespace nightmap {

struct KeyframeSource {
  std::vector<RgbdCamera> cameras;
  std::vector<Keyframe> keyframes;
  // Returns the pixels of one keyframe, or none when it sees nothing of the region. Called from
  // several threads. Throws DataError when they are unreadable.
  std::function<RgbdImages(const Keyframe&)> load;
  // Returns the depth of any keyframe, even if it sees nothing of the region. It is cheaper.
  std::function<DepthImage(const Keyframe&)> load_depth;
  MapRegion region;  // part of the map that is wanted
};

// Every `stride`-th pose of a trajectory with the frame of the same time. Leaves out frames without
// depth. Throws DataError when a pose has no frame or a frame no camera.
std::vector<Keyframe> SelectKeyframes(const std::vector<FrameRecord>& frames,
                                      const std::vector<RgbdCamera>& cameras,
                                      const std::vector<StampedPose>& keyframe_poses,
                                      int stride);

// Every keyframe of the input `tile` whose keyframe_idx is a multiple of `stride` and that may be
// used, with pixels from `data` and without what moves by `masks`. Throws UsageError when the list
// does not reach to max_range_m.
KeyframeSource OpenTile(const StageContext& context, int stride, double max_range_m);

// Throws DataError when a keyframe and its view do not fit in a cube of +-reach_m.
void CheckReach(const std::vector<Keyframe>& keyframes, double max_range_m, double reach_m);

// Calls merge(work(keyframe, images)) for each keyframe that sees something of the region. `work`
// runs on several threads, `merge` in the order of the keyframes, so results do not depend on the
// number of threads. At most four keyframes per thread are in memory. Returns why keyframes were
// skipped (unreadable pixels, or any other failure that FrameFailure catches).
template <typename Partial>
std::vector<std::string> FuseKeyframes(
    const KeyframeSource& source,
    Progress& progress,
    int num_threads,
    const std::function<Partial(const Keyframe&, const RgbdImages&)>& work,
    const std::function<void(Partial&&)>& merge) {
  const std::size_t batch = static_cast<std::size_t>(std::max(1, num_threads)) * 4;
  std::vector<std::string> skipped;
  progress.Start(source.keyframes.size());
  for (std::size_t begin = 0; begin < source.keyframes.size(); begin += batch) {
    const std::size_t count = std::min(batch, source.keyframes.size() - begin);
    std::vector<std::optional<Partial>> partials(count);
    std::vector<std::string> reasons(count);
    ParallelFor(count, num_threads, [&](std::size_t i) {
      const Keyframe& keyframe = source.keyframes[begin + i];
      reasons[i] = FrameFailure(keyframe.frame.color.path, [&] {
        const RgbdImages images = source.load(keyframe);
        if (!images.depth.pixels.empty()) partials[i] = work(keyframe, images);
      });
    });
    for (std::size_t i = 0; i < count; ++i) {
      if (partials[i]) merge(std::move(*partials[i]));
      if (!reasons[i].empty()) skipped.push_back(std::move(reasons[i]));
    }
    progress.Advance(count);
  }
  progress.Finish();
  return skipped;
}

}  // namespace nightmap
