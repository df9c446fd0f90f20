// SPDX-License-Identifier: Apache-2.0
// Level surfaces among the patches that depth images see: floors, tables, counters.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/map_frame/surface_patches.h"

namespace nightmap {

inline constexpr double kLevelBand_m = 0.04;  // half thickness of a level surface's points

// The patches that face up, for which a surface is level.
std::vector<SurfacePatch> FacingUp(const std::vector<SurfacePatch>& patches,
                                   const Eigen::Vector3d& up);

struct LevelSurface {
  using Cell = std::pair<int, int>;  // of 0.1 m x 0.1 m

  double height_m = 0;    // up . point
  std::set<Cell> cells;   // where it was seen: overlapping views count once
  int num_keyframes = 0;  // that saw it
  int num_patches = 0;
  int num_patches_about = 0;  // in the bands right below and above it, together as thick as it

  double Area_m2() const { return 0.01 * static_cast<double>(cells.size()); }
  // Whether it stands out of what lies about it more than chance explains.
  bool IsDistinct() const;
};

class LevelMap {
 public:
  // `up` of unit length, in the patches' frame; the patches' camera_idx counts in `cameras`.
  LevelMap(const std::vector<SurfacePatch>& patches,
           const std::vector<Rigid3>& given_from_cameras,
           const Eigen::Vector3d& up);

  // One for each height with more level surface than right below and above it; rising.
  std::vector<LevelSurface> Surfaces() const;

  // Whether cameras saw more than a quarter of the lower surface through the higher one: surfaces
  // are opaque, so it is a reflection or noise. Rays near the border of the higher one pass it.
  bool IsSeenThrough(const LevelSurface& high, const LevelSurface& low) const;

  // Share of the patches of any direction that lie more than `depth_m` below a surface. Only
  // patches count that another keyframe saw too, within 0.1 m, and none that is seen through the
  // surface.
  double ShareBelow(const LevelSurface& surface, double depth_m) const;

  // Height under which hardly any patch lies, of the same patches or, if there is none, of all.
  // There must be a patch.
  double LowestHeight_m() const;

  int NumKeyframes() const { return num_keyframes_; }  // that have a patch

 private:
  struct Sample {
    Eigen::Vector3d point;                  // x and y across, z along up
    std::optional<Eigen::Vector3d> camera;  // the same of the camera that saw it, where known
    int camera_idx = 0;
  };
  static LevelSurface::Cell CellOf(const Eigen::Vector3d& point);
  // Whether the ray from the camera went through the inside of the surface.
  static bool Passes(const Sample& sample, const LevelSurface& surface);
  LevelSurface SurfaceAt(double height_m) const;
  void KeepCorroborated(const std::vector<Sample>& all);

  std::vector<double> level_heights_m_;  // peaks, rising
  std::vector<Sample> level_;            // those that face up
  std::vector<Sample> corroborated_;     // of any direction
  std::vector<double> heights_m_;        // of all
  int num_keyframes_ = 0;
};

}  // namespace nightmap
