// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/choose_floor.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pipeline/base/median.h"

namespace nightmap {
namespace {

constexpr int kMinKeyframes = 3;
constexpr double kMinShareOfLargest = 0.05;
constexpr double kSmearedArea_m2 = 1.0;     // surfaces of this area or more need not stand out
constexpr double kStep_m = 0.15;            // nearer surfaces are one, with steps or drift
constexpr double kMaxCameraHeight_m = 2.5;  // above the floor on which the person stands
constexpr double kMinStorey_m = 2.0;

class FloorFinder {
 public:
  FloorFinder(const MapFrameOptions& options,
              const std::vector<SurfacePatch>& patches,
              const std::vector<Rigid3>& given_from_cameras,
              const Eigen::Vector3d& up)
      : options_(options), map_(patches, given_from_cameras, up) {
    for (const Rigid3& pose : given_from_cameras) {
      cameras_m_.push_back(up.dot(pose.translation));
    }
    const double median_m = MedianHeight_m(given_from_cameras, up);
    for (LevelSurface& surface : map_.Surfaces()) {
      if (median_m - surface.height_m < options.floor_min_camera_height_m) break;
      surfaces_.push_back(std::move(surface));
    }
    FindSupported();
  }

  FloorChoice Choose() const {
    if (const auto floor = Floor()) return ChoiceOf(*floor, "floor plane");
    if (const auto lowest = LowestWithNothingBelow()) {
      return ChoiceOf(*lowest, "lowest horizontal plane");
    }
    LevelSurface none;
    none.height_m = std::ranges::min(cameras_m_);
    if (map_.NumKeyframes() == 0) return ChoiceOf(none, "lowest camera");
    none.height_m = map_.LowestHeight_m();
    return ChoiceOf(none, "lowest points");
  }

 private:
  FloorChoice ChoiceOf(const LevelSurface& surface, const char* source) const {
    return {surface, source, map_.ShareBelow(surface, kBelowFloor_m)};
  }

  bool IsLargeEnough(const LevelSurface& surface, double largest_m2) const {
    const double area_m2 = surface.Area_m2();
    return area_m2 >= std::max(options_.floor_min_area_m2, kMinShareOfLargest * largest_m2) &&
           (area_m2 >= kSmearedArea_m2 || surface.IsDistinct());
  }

  bool IsReflection(const LevelSurface& surface) const {
    return std::ranges::any_of(supported_, [&](const LevelSurface& high) {
      return high.height_m > surface.height_m + kStep_m && high.num_patches > surface.num_patches &&
             map_.IsSeenThrough(high, surface);
    });
  }

  // From the highest down, because a surface is seen through those above it.
  void FindSupported() {
    double largest_m2 = 0;
    for (const auto& surface : surfaces_) largest_m2 = std::max(largest_m2, surface.Area_m2());
    const int min_keyframes = std::min(kMinKeyframes, map_.NumKeyframes());
    for (auto surface = surfaces_.rbegin(); surface != surfaces_.rend(); ++surface) {
      if (surface->num_keyframes < min_keyframes || !IsLargeEnough(*surface, largest_m2)) continue;
      if (!IsReflection(*surface)) supported_.insert(supported_.begin(), *surface);
    }
  }

  bool IsStoodOn(const LevelSurface& surface) const {
    return std::ranges::any_of(cameras_m_, [&](double camera_m) {
      return camera_m > surface.height_m && camera_m <= surface.height_m + kMaxCameraHeight_m;
    });
  }

  // Returns the largest of the supported surfaces that lie within a step above `lowest`.
  LevelSurface LargestWithinStep(const LevelSurface& lowest) const {
    LevelSurface largest = lowest;
    for (const LevelSurface& surface : supported_) {
      const double up_m = surface.height_m - lowest.height_m;
      if (up_m >= 0 && up_m <= kStep_m && surface.Area_m2() > largest.Area_m2()) largest = surface;
    }
    return largest;
  }

  // The lowest surface, except where cameras stood on a larger one a storey above and never on it.
  std::optional<LevelSurface> Floor() const {
    if (supported_.empty()) return std::nullopt;
    const LevelSurface& lowest = supported_.front();
    const auto upstairs = std::ranges::find_if(supported_, [&](const LevelSurface& surface) {
      return surface.height_m >= lowest.height_m + kMinStorey_m && IsStoodOn(surface) &&
             surface.Area_m2() > lowest.Area_m2();
    });
    if (!IsStoodOn(lowest) && upstairs != supported_.end()) return LargestWithinStep(*upstairs);
    const LevelSurface floor = LargestWithinStep(lowest);
    if (!HasNothingBelow(floor)) return std::nullopt;
    return floor;
  }

  bool HasNothingBelow(const LevelSurface& surface) const {
    return map_.ShareBelow(surface, kBelowFloor_m) <= kMaxBelowFloorShare;
  }

  // Prefers a higher surface only if it is more than twice as large.
  std::optional<LevelSurface> LowestWithNothingBelow() const {
    std::optional<LevelSurface> chosen;
    for (const LevelSurface& surface : surfaces_) {
      if (chosen && surface.Area_m2() <= 2 * chosen->Area_m2()) continue;
      if (HasNothingBelow(surface)) chosen = surface;
    }
    return chosen;
  }

  const MapFrameOptions& options_;
  LevelMap map_;
  std::vector<double> cameras_m_;        // heights
  std::vector<LevelSurface> surfaces_;   // below the cameras, ascending
  std::vector<LevelSurface> supported_;  // the certain surfaces, ascending
};

}  // namespace

double MedianHeight_m(const std::vector<Rigid3>& given_from_cameras, const Eigen::Vector3d& up) {
  std::vector<double> heights;
  for (const Rigid3& pose : given_from_cameras) heights.push_back(up.dot(pose.translation));
  return Median(std::move(heights));
}

FloorChoice ChooseFloor(const MapFrameOptions& options,
                        const std::vector<SurfacePatch>& patches,
                        const std::vector<Rigid3>& given_from_cameras,
                        const Eigen::Vector3d& up) {
  return FloorFinder(options, patches, given_from_cameras, up).Choose();
}

}  // namespace nightmap
