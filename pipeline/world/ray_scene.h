// SPDX-License-Identifier: Apache-2.0
// Ray casting against the surfaces of a scene (Embree; Wald et al., SIGGRAPH 2014).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "pipeline/world/scene.h"

namespace nightmap {

struct RayHit {
  int surface_idx = -1;  // -1: no hit
  double distance = 0;   // in units of the direction's length; exact on the surface's plane
  double a = 0, b = 0;   // position on the surface, in [0, 1]
};

// Thread safe after construction. Uses the same instruction set on every machine, so hits are
// equal.
class RayScene {
 public:
  explicit RayScene(const std::vector<Surface>& surfaces);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  // Nearest surface along a ray, from either side.
  RayHit Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  // The same when the nearest surface is known.
  RayHit HitOn(int surface_idx,
               const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction) const;
  // Whether anything lies on the ray within (0, max_distance), in units of the direction's length.
  bool IsBlocked(const Eigen::Vector3d& origin,
                 const Eigen::Vector3d& direction,
                 double max_distance) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nightmap
