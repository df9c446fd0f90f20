// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/depth_consistency.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/dense/point_cloud/fuse_depth.h"

namespace nightmap {
namespace {

constexpr std::size_t kVoxelsPerRun = 64;

// Successive voxels and a ball around them.
struct PositionRun {
  std::size_t begin = 0;
  std::size_t end = 0;
  Eigen::Vector3d centre;
  double radius_m = 0;
};

struct Votes {
  int num_confirming = 0;
  int num_seeing_through = 0;

  bool Keep(int min_frames) const {
    return num_confirming >= min_frames && num_seeing_through <= num_confirming;
  }
};

std::vector<PositionRun> MakeRuns(const std::vector<Eigen::Vector3d>& positions) {
  std::vector<PositionRun> runs;
  for (std::size_t begin = 0; begin < positions.size(); begin += kVoxelsPerRun) {
    const std::size_t end = std::min(begin + kVoxelsPerRun, positions.size());
    Eigen::AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i) box.extend(positions[i]);
    runs.push_back({begin, end, box.center(), 0.5 * box.diagonal().norm()});
  }
  return runs;
}

std::vector<std::optional<DepthView>> LoadViews(const KeyframeSource& source,
                                                std::span<const Keyframe> keyframes,
                                                int num_threads) {
  std::vector<std::optional<DepthView>> views(keyframes.size());
  ParallelFor(keyframes.size(), num_threads, [&](std::size_t i) {
    const Keyframe& keyframe = keyframes[i];
    const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
    std::ignore = FrameFailure(keyframe.frame.depth.path, [&] {  // FuseDepth reports the failure
      views[i].emplace(
          source.cameras[camera], keyframe.map_from_camera, source.load_depth(keyframe));
    });
  });
  return views;
}

void Vote(const PointCloudOptions& options,
          const DepthView& view,
          const PositionRun& run,
          const std::vector<Eigen::Vector3d>& positions,
          std::vector<Votes>& votes) {
  if (!view.Reaches(run.centre, run.radius_m, options.max_depth_m)) return;
  for (std::size_t i = run.begin; i < run.end; ++i) {
    const Testimony testimony = view.Of(options, positions[i]);
    votes[i].num_confirming += testimony == Testimony::kConfirms;
    votes[i].num_seeing_through += testimony == Testimony::kSeesThrough;
  }
}

}  // namespace

DepthView::DepthView(const RgbdCamera& camera, const Rigid3& map_from_camera, DepthImage depth)
    : camera_(&camera),
      rotation_(map_from_camera.rotation.conjugate().toRotationMatrix()),
      translation_(-(rotation_ * map_from_camera.translation)),
      depth_(std::move(depth)) {
  for (const double x : {0, camera.color.width - 1}) {
    for (const double y : {0, camera.color.height - 1}) {
      max_tangent_ = std::max(max_tangent_, camera.color.Normalize({x, y}).norm());
    }
  }
}

Testimony DepthView::Of(const PointCloudOptions& options,
                        const Eigen::Vector3d& point_in_map) const {
  const Eigen::Vector3d point = rotation_ * point_in_map + translation_;
  if (point.z() > options.max_depth_m) return Testimony::kNone;
  const auto pixel = camera_->color.Project(point);
  if (!pixel || !camera_->color.Contains(*pixel)) return Testimony::kNone;
  const int x = static_cast<int>(std::floor(pixel->x() + 0.5));
  const int y = static_cast<int>(std::floor(pixel->y() + 0.5));
  const float measured_m = depth_.At(x, y);
  const double tolerance_m = DepthTolerance_m(options, camera_->noise.Sigma_m(point.z()));
  if (measured_m <= 0 || measured_m < point.z() - tolerance_m) return Testimony::kNone;
  if (measured_m <= point.z() + tolerance_m) return Testimony::kConfirms;
  return BesidePixel(x, y, point.z(), tolerance_m);
}

Testimony DepthView::BesidePixel(int at_x, int at_y, double depth_m, double tolerance_m) const {
  Testimony testimony = Testimony::kSeesThrough;
  for (int y = std::max(at_y - 1, 0); y <= std::min(at_y + 1, depth_.height - 1); ++y) {
    for (int x = std::max(at_x - 1, 0); x <= std::min(at_x + 1, depth_.width - 1); ++x) {
      const float measured_m = depth_.At(x, y);
      if (std::abs(measured_m - depth_m) <= tolerance_m) return Testimony::kConfirms;
      if (measured_m > 0 && measured_m < depth_m) testimony = Testimony::kNone;
    }
  }
  return testimony;
}

bool DepthView::Reaches(const Eigen::Vector3d& centre_in_map,
                        double radius_m,
                        double max_depth_m) const {
  const Eigen::Vector3d centre = rotation_ * centre_in_map + translation_;
  if (centre.z() < -radius_m || centre.z() > max_depth_m + radius_m) return false;
  const double secant = std::sqrt(1 + max_tangent_ * max_tangent_);
  return centre.head<2>().norm() <= std::max(centre.z(), 0.0) * max_tangent_ + radius_m * secant;
}

SortedVoxels RemoveInconsistent(const PointCloudOptions& options,
                                const SortedVoxels& voxels,
                                const KeyframeSource& source,
                                Progress& progress,
                                int num_threads) {
  const std::vector<Eigen::Vector3d> positions = Positions(voxels.sums);
  const std::vector<PositionRun> runs = MakeRuns(positions);
  std::vector<Votes> votes(positions.size());
  const std::size_t batch = static_cast<std::size_t>(std::max(1, num_threads)) * 4;
  const std::span<const Keyframe> keyframes = source.keyframes;
  progress.Start(keyframes.size());
  for (std::size_t begin = 0; begin < keyframes.size(); begin += batch) {
    const auto some = keyframes.subspan(begin, std::min(batch, keyframes.size() - begin));
    const auto views = LoadViews(source, some, num_threads);
    ParallelFor(runs.size(), num_threads, [&](std::size_t run) {
      for (const auto& view : views) {
        if (view) Vote(options, *view, runs[run], positions, votes);
      }
    });
    progress.Advance(some.size());
  }
  progress.Finish();
  return Select(voxels,
                [&](std::size_t i) { return votes[i].Keep(options.min_consistent_frames); });
}

}  // namespace nightmap
