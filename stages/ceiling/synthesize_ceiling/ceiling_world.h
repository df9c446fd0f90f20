// SPDX-License-Identifier: Apache-2.0
// The painted building: what every face of a CeilingPlan looks like.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/ceiling/synthesize_ceiling/ceiling_plan.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_raster.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_walk.h"

namespace nightmap {

// Lamps are so much brighter than all else that they saturate.
inline constexpr float kLampBrightness = 1400;

struct CeilingFaceLook {
  CeilingRaster raster;
  Eigen::Vector3f tint = Eigen::Vector3f::Ones();  // RGB
};

// Immutable and safe to share between threads.
struct CeilingWorld {
  CeilingPlan plan;
  CeilingWalk walk;
  std::vector<CeilingFaceLook> faces;  // by CeilingHit::FaceIdx()
};

// Paints ceilings at 4 mm and walls at 8 mm per cell. Depends on plan and seed alone; takes about
// 300 MB for PlanCeilingCorridor.
CeilingWorld PaintCeilingWorld(CeilingPlan plan, int seed, int num_threads);

// The two kinds of faces. `seed` decides specks and blemishes, together with the rectangle's look.
CeilingRaster PaintCeiling(const CeilingPlan& plan, int rect, int seed);
CeilingRaster PaintWall(const CeilingRect& rect, int side, int seed);

}  // namespace nightmap
