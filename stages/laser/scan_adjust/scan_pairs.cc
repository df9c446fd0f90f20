// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/scan_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/geometry/plane_grid.h"

namespace nightmap {
namespace {

// Scans up to so far apart are compared; a turn of a radian counts as a metre.
constexpr double kNeighbourDistance_m = 3;
// A turn by a radian counts as much as so many metres.
constexpr double kMetresPerRadian = 1;

double Apart(const Rigid2& a, const Rigid2& b) {
  return (a.translation - b.translation).norm() +
         kMetresPerRadian * std::abs(WrapAngle_rad(a.heading_rad - b.heading_rad));
}

// Path driven to each keyscan.
std::vector<double> Paths_m(const std::vector<Rigid2>& poses) {
  std::vector<double> paths_m;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double step_m = i == 0 ? 0 : (poses[i].translation - poses[i - 1].translation).norm();
    paths_m.push_back(i == 0 ? 0 : paths_m.back() + step_m);
  }
  return paths_m;
}

std::vector<Eigen::Vector2d> Places(const std::vector<Rigid2>& poses) {
  std::vector<Eigen::Vector2d> places;
  for (const Rigid2& pose : poses) places.push_back(pose.translation);
  return places;
}

class Chooser {
 public:
  Chooser(const ScanAdjustOptions& options, const std::vector<Rigid2>& poses)
      : options_(options),
        poses_(poses),
        paths_m_(Paths_m(poses)),
        grid_(Places(poses), kNeighbourDistance_m) {}

  void AddNearInTime(std::size_t scan, std::vector<ScanPair>* pairs) const {
    std::size_t back = 1;
    for (int i = 0; i < options_.num_near_in_time && back <= scan; ++i, back *= 2) {
      const std::size_t target = scan - back;
      if (Apart(poses_[scan], poses_[target]) > kNeighbourDistance_m) return;
      pairs->push_back({scan, target});
      pairs->push_back({target, scan});
    }
  }

  void AddOfOtherTimes(std::size_t scan, std::vector<ScanPair>* pairs) const {
    std::vector<std::pair<double, std::size_t>> near;
    for (const std::size_t target : grid_.Near(poses_[scan].translation, kNeighbourDistance_m)) {
      if (std::abs(paths_m_[scan] - paths_m_[target]) < kOtherTime_m) continue;
      const double apart = Apart(poses_[scan], poses_[target]);
      if (apart <= kNeighbourDistance_m) near.emplace_back(apart, target);
    }
    const auto count = std::min(near.size(), static_cast<std::size_t>(options_.num_of_other_times));
    std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = 0; i < count; ++i) pairs->push_back({scan, near[i].second});
  }

 private:
  const ScanAdjustOptions& options_;
  const std::vector<Rigid2>& poses_;
  std::vector<double> paths_m_;
  PlaneGrid grid_;
};

}  // namespace

std::vector<ScanPair> ChoosePairs(const ScanAdjustOptions& options,
                                  const std::vector<Rigid2>& graph_from_robot) {
  const Chooser chooser(options, graph_from_robot);
  std::vector<ScanPair> pairs;
  for (std::size_t scan = 0; scan < graph_from_robot.size(); ++scan) {
    chooser.AddNearInTime(scan, &pairs);
    chooser.AddOfOtherTimes(scan, &pairs);
  }
  return pairs;
}

}  // namespace nightmap
