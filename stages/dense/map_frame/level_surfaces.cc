// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/level_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace nightmap {
namespace {

constexpr double kMaxTilt_rad = 0.15;
constexpr double kBin_m = 0.02;  // of the height histogram
constexpr double kCell_m = 0.1;

// Peaks of the height histogram, ascending.
std::vector<double> PeakHeights_m(const std::vector<SurfacePatch>& level,
                                  const Eigen::Vector3d& up) {
  std::map<int, double> histogram;
  for (const SurfacePatch& patch : level) {
    histogram[static_cast<int>(std::floor(up.dot(patch.point) / kBin_m))] += patch.area_m2;
  }
  const auto at = [&](int bin) {
    const auto found = histogram.find(bin);
    return found == histogram.end() ? 0.0 : found->second;
  };
  const auto smooth = [&](int bin) { return at(bin - 1) + at(bin) + at(bin + 1); };
  std::vector<double> heights_m;
  for (const auto& [bin, area] : histogram) {
    const double here = smooth(bin);
    if (here >= smooth(bin - 1) && here > smooth(bin + 1))
      heights_m.push_back((bin + 0.5) * kBin_m);
  }
  return heights_m;
}

// Whether a cell and its four neighbours belong to the surface, so that a ray there misses the
// border.
bool IsInside(const LevelSurface& surface, const LevelSurface::Cell& cell) {
  const auto& [x, y] = cell;
  const LevelSurface::Cell near[] = {cell, {x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}};
  return std::ranges::all_of(
      near, [&](const LevelSurface::Cell& other) { return surface.cells.contains(other); });
}

}  // namespace

std::vector<SurfacePatch> FacingUp(const std::vector<SurfacePatch>& patches,
                                   const Eigen::Vector3d& up) {
  std::vector<SurfacePatch> chosen;
  std::ranges::copy_if(patches, std::back_inserter(chosen), [&](const SurfacePatch& patch) {
    return Angle_rad(patch.normal, up) < kMaxTilt_rad;
  });
  return chosen;
}

// Requires twice as many patches, and a difference of three standard deviations.
bool LevelSurface::IsDistinct() const {
  const double more = num_patches - num_patches_about;
  return num_patches >= 2 * num_patches_about &&
         more >= 3 * std::sqrt(num_patches + num_patches_about);
}

LevelMap::LevelMap(const std::vector<SurfacePatch>& patches,
                   const std::vector<Rigid3>& given_from_cameras,
                   const Eigen::Vector3d& up) {
  Eigen::Matrix3d level_from_given;
  level_from_given.row(0) = up.unitOrthogonal();
  level_from_given.row(1) = up.cross(up.unitOrthogonal());
  level_from_given.row(2) = up;
  const auto sample_of = [&](const SurfacePatch& patch) {
    Sample sample{level_from_given * patch.point, {}, patch.camera_idx};
    if (patch.camera_idx >= 0) {
      const auto idx = static_cast<std::size_t>(patch.camera_idx);
      sample.camera = level_from_given * given_from_cameras.at(idx).translation;
    }
    return sample;
  };
  const auto level = FacingUp(patches, up);
  level_heights_m_ = PeakHeights_m(level, up);
  for (const SurfacePatch& patch : level) level_.push_back(sample_of(patch));
  std::vector<Sample> all;
  std::set<int> keyframes;
  for (const SurfacePatch& patch : patches) {
    all.push_back(sample_of(patch));
    heights_m_.push_back(all.back().point.z());
    keyframes.insert(patch.camera_idx);
  }
  num_keyframes_ = static_cast<int>(keyframes.size());
  KeepCorroborated(all);
}

void LevelMap::KeepCorroborated(const std::vector<Sample>& all) {
  struct Seen {
    int by = 0;
    bool again = false;  // confirmed by another keyframe
  };
  std::map<std::array<int, 3>, Seen> voxels;
  const auto voxel_of = [](const Eigen::Vector3d& point) {
    const Eigen::Array3i voxel = (point / kCell_m).array().floor().cast<int>();
    return std::array<int, 3>{voxel.x(), voxel.y(), voxel.z()};
  };
  for (const Sample& sample : all) {
    const auto [voxel, is_new] =
        voxels.try_emplace(voxel_of(sample.point), Seen{sample.camera_idx, false});
    voxel->second.again |= voxel->second.by != sample.camera_idx;
  }
  for (const Sample& sample : all) {
    if (voxels.at(voxel_of(sample.point)).again) corroborated_.push_back(sample);
  }
}

LevelSurface::Cell LevelMap::CellOf(const Eigen::Vector3d& point) {
  return {static_cast<int>(std::floor(point.x() / kCell_m)),
          static_cast<int>(std::floor(point.y() / kCell_m))};
}

LevelSurface LevelMap::SurfaceAt(double height_m) const {
  LevelSurface surface;
  surface.height_m = height_m;
  std::set<int> keyframes;
  for (const Sample& sample : level_) {
    const double off_m = sample.point.z() - height_m;
    if (std::abs(off_m) > 2 * kLevelBand_m) continue;
    const bool is_about = std::abs(off_m) > kLevelBand_m;
    ++(is_about ? surface.num_patches_about : surface.num_patches);
    if (is_about) continue;
    surface.cells.insert(CellOf(sample.point));
    keyframes.insert(sample.camera_idx);
  }
  surface.num_keyframes = static_cast<int>(keyframes.size());
  return surface;
}

std::vector<LevelSurface> LevelMap::Surfaces() const {
  std::vector<LevelSurface> surfaces;
  for (const double height_m : level_heights_m_) surfaces.push_back(SurfaceAt(height_m));
  return surfaces;
}

bool LevelMap::Passes(const Sample& sample, const LevelSurface& surface) {
  if (!sample.camera) return false;
  const double above_m = sample.camera->z() - surface.height_m;
  const double below_m = surface.height_m - sample.point.z();
  if (above_m <= 0 || below_m <= 0) return false;
  const Eigen::Vector3d crossing =
      *sample.camera + (sample.point - *sample.camera) * (above_m / (above_m + below_m));
  return IsInside(surface, CellOf(crossing));
}

bool LevelMap::IsSeenThrough(const LevelSurface& high, const LevelSurface& low) const {
  int num_patches = 0;
  int num_through = 0;
  for (const Sample& sample : level_) {
    if (std::abs(sample.point.z() - low.height_m) > kLevelBand_m) continue;
    ++num_patches;
    if (Passes(sample, high)) ++num_through;
  }
  return 4 * num_through > num_patches;
}

double LevelMap::ShareBelow(const LevelSurface& surface, double depth_m) const {
  if (corroborated_.empty()) return 0;
  const auto count = std::ranges::count_if(corroborated_, [&](const Sample& sample) {
    return sample.point.z() < surface.height_m - depth_m && !Passes(sample, surface);
  });
  return static_cast<double>(count) / static_cast<double>(corroborated_.size());
}

double LevelMap::LowestHeight_m() const {
  constexpr double kOutliers = 0.01;
  std::vector<double> heights_m = heights_m_;
  if (!corroborated_.empty()) {
    heights_m.clear();
    for (const Sample& sample : corroborated_) heights_m.push_back(sample.point.z());
  }
  const auto rank = static_cast<std::ptrdiff_t>(kOutliers * static_cast<double>(heights_m.size()));
  std::ranges::nth_element(heights_m, heights_m.begin() + rank);
  return heights_m[static_cast<std::size_t>(rank)];
}

}  // namespace nightmap
