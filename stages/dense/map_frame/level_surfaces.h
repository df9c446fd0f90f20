// SPDX-License-Identifier: Apache-2.0
// Level surfaces among the surface patches of depth images: floors, tables, counters.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/dense/map_frame/surface_patches.h"

namespace nightmap {

inline constexpr double kLevelBand_m = 0.04;  // half thickness of a level surface's points

// The patches that face up closely enough to belong to a level surface.
std::vector<SurfacePatch> FacingUp(const std::vector<SurfacePatch>& patches,
                                   const Eigen::Vector3d& up);

struct LevelSurface {
  using Cell = std::pair<int, int>;  // 0.1 m x 0.1 m

  double height_m = 0;    // up . point
  std::set<Cell> cells;   // cells in which it was seen; overlapping views count once
  int num_keyframes = 0;  // number of keyframes that saw it
  int num_patches = 0;
  // In the bands directly below and above, which together are as thick as it.
  int num_patches_about = 0;

  double Area_m2() const { return 0.01 * static_cast<double>(cells.size()); }
  // Whether it has more patches than its surroundings by more than chance explains.
  bool IsDistinct() const;
};

class LevelMap {
 public:
  // `up` is of unit length, in the patches' frame; the patches' camera_idx are indices into
  // `cameras`.
  LevelMap(const std::vector<SurfacePatch>& patches,
           const std::vector<Rigid3>& given_from_cameras,
           const Eigen::Vector3d& up);

  // One surface for each height with more level area than directly below and above; ascending.
  std::vector<LevelSurface> Surfaces() const;

  // Whether cameras saw more than a quarter of the lower surface through the higher one. Surfaces
  // are opaque, so the lower one is then a reflection or noise. Rays near the border of the higher
  // surface do not count.
  bool IsSeenThrough(const LevelSurface& high, const LevelSurface& low) const;

  // Share of the patches, in any direction, that lie more than `depth_m` below a surface. Counts
  // only patches that another keyframe confirms within 0.1 m, and none that is seen through the
  // surface.
  double ShareBelow(const LevelSurface& surface, double depth_m) const;

  // Height below which only a negligible share of the confirmed patches lies or, without any
  // confirmed patch, of all patches. There must be a patch.
  double LowestHeight_m() const;

  int NumKeyframes() const { return num_keyframes_; }  // keyframes that have a patch

 private:
  struct Sample {
    Eigen::Vector3d point;  // x and y across, z along up
    // Position of the camera that saw it, where known; same axes.
    std::optional<Eigen::Vector3d> camera;
    int camera_idx = 0;
  };
  static LevelSurface::Cell CellOf(const Eigen::Vector3d& point);
  // Whether the ray from the camera passed through the interior of the surface.
  static bool Passes(const Sample& sample, const LevelSurface& surface);
  LevelSurface SurfaceAt(double height_m) const;
  void KeepCorroborated(const std::vector<Sample>& all);

  std::vector<double> level_heights_m_;  // peaks, ascending
  std::vector<Sample> level_;            // samples that face up
  std::vector<Sample> corroborated_;     // in any direction, confirmed by another keyframe
  std::vector<double> heights_m_;        // of all samples
  int num_keyframes_ = 0;
};

}  // namespace nightmap
