// SPDX-License-Identifier: Apache-2.0
// Runs the landmarks stage on a scene.
#pragma once

#include "stages/camera/landmarks/landmarks.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap {

struct LandmarksRun {
  LandmarkMap map;
  LandmarksFigures figures;
  std::vector<LandmarkRegion> regions;
};

inline LandmarksRun RunOnScene(const LandmarksOptions& options,
                               const LandmarksInput& input,
                               int num_threads = 1) {
  LandmarksRun run;
  run.map = HeadOfMap(options, input);
  const auto take = [&](const Rectangle& box, const LandmarkMap& region) {
    run.regions.push_back({box, region.NumLandmarks(), {}});
    AppendLandmarks(region, &run.map);
  };
  run.figures = RunLandmarks(options, input, take, NoProgress(), num_threads);
  return run;
}

}  // namespace nightmap
