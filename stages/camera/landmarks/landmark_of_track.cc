// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/landmark_of_track.h"

#include <algorithm>
#include <limits>

#include "pipeline/camera/descriptor_distance.h"
#include "pipeline/geometry/reprojection.h"

namespace nightmap {
namespace {

constexpr int kMaxDescriptors = 3;  // descriptors kept per landmark
// A further descriptor of a landmark is kept when it differs by at least this.
constexpr double kMinDescriptorDifference = 0.3;

class Finisher {
 public:
  Finisher(const LandmarksOptions& options,
           DescriptorKind kind,
           const std::vector<Observer>& observers)
      : options_(options), kind_(kind), observers_(observers) {}

  std::optional<Landmark> Finish(const LandmarkTrack& track) const {
    Landmark landmark;
    landmark.position_in_map = track.position_in_map;
    PointEstimate estimate;
    for (const Sighting& sighting : track.sightings) {
      const Observer& observer = observers_[static_cast<std::size_t>(sighting.frame_idx)];
      const Eigen::Vector3d point_in_camera =
          observer.map_from_camera.Inverse() * track.position_in_map;
      const auto pixel = observer.features->Feature(sighting.feature_idx).Pixel();
      if (ReprojectionError_px(observer.camera->color, point_in_camera, pixel) >
          options_.tracker.max_error_px) {
        continue;
      }
      estimate.Add(
          observer, sighting.feature_idx, point_in_camera.z(), options_.tracker.pixel_sigma_px);
      landmark.sightings.push_back(sighting);
    }
    if (static_cast<int>(landmark.sightings.size()) < options_.min_observations) return {};
    landmark.position_in_map = estimate.Position();
    landmark.sigma_m = estimate.Sigma_m();
    if (!(landmark.sigma_m <= options_.max_position_sigma_m)) return {};
    landmark.descriptors = ChooseDescriptors(landmark.sightings);
    return landmark;
  }

 private:
  // At most `count` observations, spread evenly over all, which bounds the quadratic work below.
  std::vector<const std::uint8_t*> SampleDescriptors(const Track& sightings,
                                                     std::size_t count) const {
    const std::size_t num_sampled = std::min(count, sightings.size());
    std::vector<const std::uint8_t*> descriptors;
    for (std::size_t i = 0; i < num_sampled; ++i) {
      const Sighting& sighting = sightings[i * sightings.size() / num_sampled];
      const Observer& observer = observers_[static_cast<std::size_t>(sighting.frame_idx)];
      descriptors.push_back(observer.features->Feature(sighting.feature_idx).Descriptor(kind_));
    }
    return descriptors;
  }

  // Chooses the medoid, then repeatedly the descriptor farthest from the chosen ones while it
  // differs enough.
  std::vector<const std::uint8_t*> ChooseDescriptors(const Track& sightings) const {
    constexpr std::size_t kMaxSampled = 24;
    const auto samples = SampleDescriptors(sightings, kMaxSampled);
    const int min_difference = DistanceFromRelative(kind_, kMinDescriptorDifference);
    std::vector<const std::uint8_t*> chosen{samples[Medoid(samples)]};
    std::vector<int> nearest(samples.size(), std::numeric_limits<int>::max());
    while (static_cast<int>(chosen.size()) < kMaxDescriptors) {
      for (std::size_t i = 0; i < samples.size(); ++i) {
        nearest[i] = std::min(nearest[i], DescriptorDistance(kind_, samples[i], chosen.back()));
      }
      const auto farthest = std::max_element(nearest.begin(), nearest.end());
      if (*farthest < min_difference) break;
      chosen.push_back(samples[static_cast<std::size_t>(farthest - nearest.begin())]);
    }
    return chosen;
  }

  std::size_t Medoid(const std::vector<const std::uint8_t*>& samples) const {
    std::vector<std::int64_t> sums(samples.size(), 0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      for (std::size_t k = 0; k < samples.size(); ++k) {
        sums[i] += DescriptorDistance(kind_, samples[i], samples[k]);
      }
    }
    return static_cast<std::size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin());
  }

  const LandmarksOptions& options_;
  DescriptorKind kind_;
  const std::vector<Observer>& observers_;
};

}  // namespace

std::optional<Landmark> LandmarkOfTrack(const LandmarksOptions& options,
                                        DescriptorKind kind,
                                        const std::vector<Observer>& observers,
                                        const LandmarkTrack& track) {
  return Finisher(options, kind, observers).Finish(track);
}

}  // namespace nightmap
