// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/object_icp.h"

#include <pcl/console/print.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_2D.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>

namespace nightmap {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Points = std::vector<Eigen::Vector2d>;

constexpr int kMaxAlignments = 60;
constexpr std::size_t kMinPoints = 5;
constexpr double kSlack_m = 1;     // that a start may be off
constexpr double kEpsilon = 1e-7;  // squared motion at which the matching has converged

Cloud::Ptr ToCloud(const Points& points) {
  auto cloud = std::make_shared<Cloud>();
  for (const Eigen::Vector2d& point : points) {
    cloud->emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()), 0.0F);
  }
  return cloud;
}

// PCL would print every start from which too few points have a pair.
void SilencePcl() {
  static std::once_flag once;
  std::call_once(once, pcl::console::setVerbosityLevel, pcl::console::L_ALWAYS);
}

Eigen::Vector2d MeanOf(const Points& points) {
  Eigen::Vector2d sum(0, 0);
  for (const Eigen::Vector2d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

// Matches the cloud of the submap to the walls of one object, in a frame about their middle, where
// floats are exact enough.
class ObjectMatcher {
 public:
  ObjectMatcher(const ObjectFilterOptions& options,
                const Points& walls_in_map,
                const Points& points_in_query)
      : center_(MeanOf(walls_in_map)), points_(points_in_query) {
    SilencePcl();
    Points about_center;
    for (const Eigen::Vector2d& wall : walls_in_map) {
      about_center.push_back(wall - center_);
      reach_m_ = std::max(reach_m_, kSlack_m + about_center.back().norm());
    }
    const auto estimation = std::make_shared<
        pcl::registration::TransformationEstimation2D<pcl::PointXYZ, pcl::PointXYZ>>();
    icp_.setTransformationEstimation(estimation);  // in the plane, so that nothing is mirrored
    icp_.setInputTarget(ToCloud(about_center));
    icp_.setMaxCorrespondenceDistance(options.max_pair_distance_m);
    icp_.setUseReciprocalCorrespondences(true);  // walls go on beyond the rectangle
    icp_.setMaximumIterations(kMaxAlignments);
    icp_.setTransformationEpsilon(kEpsilon);
    icp_.getConvergeCriteria()->setFailureAfterMaximumIterations(true);
  }

  // Nothing: it does not converge.
  std::optional<Rigid2> Match(const Rigid2& start) {
    const Points nearby = PointsNearby(start);
    if (nearby.size() < kMinPoints) return std::nullopt;
    icp_.setInputSource(ToCloud(nearby));
    Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
    guess.topLeftCorner<2, 2>() =
        Eigen::Rotation2Dd(start.heading_rad).toRotationMatrix().cast<float>();
    guess.topRightCorner<4, 1>().head<2>() = (start.translation - center_).cast<float>();
    Cloud aligned;
    icp_.align(aligned, guess);
    if (!icp_.hasConverged()) return std::nullopt;
    const Eigen::Matrix4d found = icp_.getFinalTransformation().cast<double>();
    return Rigid2{std::atan2(found(1, 0), found(0, 0)),
                  center_ + Eigen::Vector2d(found(0, 3), found(1, 3))};
  }

 private:
  // The part of the submap that may be matched to the object.
  Points PointsNearby(const Rigid2& start) const {
    Points nearby;
    for (const Eigen::Vector2d& point : points_) {
      if ((start * point - center_).norm() <= reach_m_) nearby.push_back(point);
    }
    return nearby;
  }

  Eigen::Vector2d center_;
  const Points& points_;
  double reach_m_ = 0;
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp_;
};

}  // namespace

Points FilterByVoxels(const Points& points, double voxel_m) {
  const auto size = static_cast<float>(voxel_m);
  pcl::VoxelGrid<pcl::PointXYZ> filter;
  filter.setInputCloud(ToCloud(points));
  filter.setLeafSize(size, size, size);
  Cloud cloud;
  filter.filter(cloud);
  Points filtered;
  for (const pcl::PointXYZ& point : cloud) filtered.emplace_back(point.x, point.y);
  return filtered;
}

std::vector<Rigid2> MatchToObject(const ObjectFilterOptions& options,
                                  const Points& walls_in_map,
                                  const Points& points_in_query,
                                  const std::vector<Rigid2>& starts) {
  ObjectMatcher matcher(options, walls_in_map, points_in_query);
  std::vector<Rigid2> poses;
  for (const Rigid2& start : starts) {
    if (const auto pose = matcher.Match(start)) poses.push_back(*pose);
  }
  return poses;
}

}  // namespace nightmap
