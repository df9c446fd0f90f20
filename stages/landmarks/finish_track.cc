// SPDX-License-Identifier: Apache-2.0
#include "stages/landmarks/finish_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/vision/descriptor_distance.h"

namespace nightmap {
namespace {

double ReprojectionError_px(const Observer& observer, int feature, const Eigen::Vector3d& point) {
  const auto pixel =
      observer.camera->color.ProjectUndistorted(observer.map_from_camera.Inverse() * point);
  if (!pixel) return std::numeric_limits<double>::infinity();
  const auto& keypoint = observer.features->keypoints_px[static_cast<std::size_t>(feature)];
  return (*pixel - keypoint.cast<double>()).norm();
}

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
    for (const Observation& observation : track.observations) {
      const Observer& observer = observers_[static_cast<std::size_t>(observation.observer)];
      if (ReprojectionError_px(observer, observation.feature, track.position_in_map) >
          options_.tracker.max_error_px) {
        continue;
      }
      const double z_m = (observer.map_from_camera.Inverse() * track.position_in_map).z();
      estimate.Add(observer, observation.feature, z_m, options_.tracker.pixel_sigma_px);
      landmark.observations.push_back(observation);
    }
    if (static_cast<int>(landmark.observations.size()) < options_.min_observations) return {};
    landmark.position_in_map = estimate.Position();
    landmark.sigma_m = estimate.Sigma_m();
    if (!(landmark.sigma_m <= options_.max_position_sigma_m)) return {};
    landmark.descriptors = ChooseDescriptors(landmark.observations);
    return landmark;
  }

 private:
  // At most `count` observations, evenly over all, bound the quadratic work below.
  std::vector<const std::uint8_t*> SampleDescriptors(const std::vector<Observation>& observations,
                                                     std::size_t count) const {
    const auto size = static_cast<std::size_t>(DescriptorSize(kind_));
    const std::size_t num_sampled = std::min(count, observations.size());
    std::vector<const std::uint8_t*> descriptors;
    for (std::size_t i = 0; i < num_sampled; ++i) {
      const Observation& observation = observations[i * observations.size() / num_sampled];
      const Observer& observer = observers_[static_cast<std::size_t>(observation.observer)];
      const auto feature = static_cast<std::size_t>(observation.feature);
      descriptors.push_back(&observer.features->descriptors[feature * size]);
    }
    return descriptors;
  }

  // The medoid, then each time the one farthest from those chosen, while it differs enough.
  std::vector<const std::uint8_t*> ChooseDescriptors(
      const std::vector<Observation>& observations) const {
    constexpr std::size_t kMaxSampled = 24;
    const auto samples = SampleDescriptors(observations, kMaxSampled);
    const int min_difference = DistanceFromRelative(kind_, options_.min_descriptor_difference);
    std::vector<const std::uint8_t*> chosen{samples[Medoid(samples)]};
    std::vector<int> nearest(samples.size(), std::numeric_limits<int>::max());
    while (static_cast<int>(chosen.size()) < options_.max_descriptors) {
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

std::optional<Landmark> FinishTrack(const LandmarksOptions& options,
                                    DescriptorKind kind,
                                    const std::vector<Observer>& observers,
                                    const LandmarkTrack& track) {
  return Finisher(options, kind, observers).Finish(track);
}

}  // namespace nightmap
