// SPDX-License-Identifier: Apache-2.0
// Which of the surfaces that were seen is the floor.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stages/map_frame/level_surfaces.h"
#include "stages/map_frame/map_frame.h"

namespace nightmap {

struct FloorChoice {
  LevelSurface surface;    // without cells where no level surface was chosen
  std::string source;      // as MapFrame::floor_source
  double below_share = 0;  // as MapFrame::below_floor_share
};

double MedianHeight_m(const std::vector<Rigid3>& given_from_cameras, const Eigen::Vector3d& up);

// The lowest level surface that is one for certain: below a floor nothing is seen, while a table or
// a counter, however large, has the floor below it.
// - It is floor_min_area_m2 large, and a twentieth of the largest level surface: what is smaller
//   may be noise or a step of stairs. A surface of less than 1 m2 must stand out of what lies about
//   it; the drift of poses smears larger ones.
// - Three keyframes saw it, or all where there are fewer.
// - It is not seen through a surface that was seen more often, as reflections in a floor are.
// - It is floor_min_camera_height_m below the median camera, at least.
// Of surfaces within 0.15 m the largest counts. A surface with a larger one 2 m or more above it is
// another storey, seen from there, if cameras were within 2.5 m above that one and never above it.
// Where more than hardly anything lies below the lowest surface, it stands on a floor that was not
// seen: z = 0 is then the lowest level surface, of any size, with hardly anything below it; else
// the height with hardly anything below it; and without any patch that of the lowest camera.
FloorChoice ChooseFloor(const MapFrameOptions& options,
                        const std::vector<SurfacePatch>& patches,
                        const std::vector<Rigid3>& given_from_cameras,
                        const Eigen::Vector3d& up);

}  // namespace nightmap
