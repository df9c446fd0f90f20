// SPDX-License-Identifier: Apache-2.0
// Chooses the floor among the level surfaces that were seen.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "stages/dense/map_frame/level_surfaces.h"
#include "stages/dense/map_frame/map_frame.h"

namespace nightmap {

struct FloorChoice {
  LevelSurface surface;    // without cells if no level surface was chosen
  std::string source;      // see MapFrame::floor_source
  double below_share = 0;  // see MapFrame::below_floor_share
};

double MedianHeight_m(const std::vector<Rigid3>& given_from_cameras, const Eigen::Vector3d& up);

// Chooses the lowest certain level surface: nothing is seen below a floor, while a table or a
// counter, however large, has the floor below it. A level surface is certain if
// - it has at least floor_min_area_m2 and a twentieth of the area of the largest level surface,
//   since smaller ones may be noise or a step of stairs; below 1 m2 it must also stand out from
//   the patches around its height, while the drift of poses smears larger ones;
// - three keyframes saw it, or all where there are fewer;
// - it is not seen through a surface that was seen more often, as reflections in a floor are;
// - it is at least floor_min_camera_height_m below the median camera.
// Among surfaces within 0.15 m the largest counts. A surface with a larger one 2 m or more above it
// is another storey, seen from that one, if cameras were within 2.5 m above the upper one and never
// above the lower one.
//
// If more than a negligible share of the patches lies below the lowest surface, that surface stands
// on a floor that was not seen. z = 0 is then the lowest level surface, of any size, with a
// negligible share below it; without one the height with a negligible share below it; and without
// any patch the height of the lowest camera.
FloorChoice ChooseFloor(const MapFrameOptions& options,
                        const std::vector<SurfacePatch>& patches,
                        const std::vector<Rigid3>& given_from_cameras,
                        const Eigen::Vector3d& up);

}  // namespace nightmap
