// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/colmap_export.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "pipeline/io/resize_picture.h"

namespace nightmap {
namespace {

struct Observation {
  int keyframe = 0;
  int landmark = 0;
  int feature = 0;
};

// By keyframe, so that the features of each are read once.
std::vector<Observation> ByKeyframe(const LandmarkMap& map) {
  std::vector<Observation> observations;
  for (int i = 0; i < map.NumLandmarks(); ++i) {
    const auto landmark = static_cast<std::size_t>(i);
    for (std::size_t k = 0; k < map.landmark_keyframes[landmark].size(); ++k) {
      observations.push_back(
          {map.landmark_keyframes[landmark][k], i, map.landmark_features[landmark][k]});
    }
  }
  std::ranges::stable_sort(observations, {}, &Observation::keyframe);
  return observations;
}

struct PointSum {
  double error_px = 0;
  std::vector<ColmapObservation> track;
};

void AddObservation(const LandmarkMap& map,
                    const ColmapModel& model,
                    const ColmapFeatures& features,
                    const Observation& seen,
                    std::vector<PointSum>* sums) {
  const auto landmark = static_cast<std::size_t>(seen.landmark);
  const ColmapImage& image = model.images[static_cast<std::size_t>(seen.keyframe)];
  const Camera& camera = model.cameras[static_cast<std::size_t>(image.camera_idx)];
  const auto pixel = camera.Project(image.camera_from_map * map.positions_in_map[landmark]);
  if (!pixel) return;
  PointSum& sum = (*sums)[landmark];
  sum.error_px += (*pixel - features.keypoints_px[static_cast<std::size_t>(seen.feature)]).norm();
  sum.track.push_back({seen.keyframe, seen.feature});
}

}  // namespace

ColmapModel StartColmapModel(const LandmarksInput& input, const LandmarkMap& head) {
  ColmapModel model;
  for (const RgbdCamera& camera : input.cameras) model.cameras.push_back(camera.Picture());
  std::vector<int> frame_idxs, camera_idxs;
  for (const MapKeyframe& keyframe : head.keyframes) {
    const FrameRecord& frame =
        input.frames[static_cast<std::size_t>(keyframe.frame_idx - input.frames.front().frame_idx)];
    model.images.push_back(
        {frame.color.path, frame.camera_idx, keyframe.map_from_camera.Inverse()});
    frame_idxs.push_back(frame.frame_idx);
    camera_idxs.push_back(frame.camera_idx);
  }
  model.features = [features = input.features,
                    cameras = input.cameras,
                    has_descriptors = head.kind == DescriptorKind::kRootSift,
                    frame_idxs = std::move(frame_idxs),
                    camera_idxs = std::move(camera_idxs)](std::size_t i) {
    const SiteFeatures::Frame frame = features.GetFrame(frame_idxs[i]);
    const RgbdCamera& camera = cameras[static_cast<std::size_t>(camera_idxs[i])];
    const Camera picture = camera.Picture();
    ColmapFeatures of_image;
    for (const Eigen::Vector2f& pixel : frame->raw_keypoints_px) {
      of_image.keypoints_px.push_back(ResizePixel(pixel.cast<double>(), camera.color, picture));
    }
    if (has_descriptors) of_image.descriptors = frame->descriptors;
    return of_image;
  };
  return model;
}

void AddColmapPoints(const LandmarkMap& region, ColmapModel* model) {
  std::vector<PointSum> sums(region.positions_in_map.size());
  ColmapFeatures features;
  int keyframe = -1;
  for (const Observation& seen : ByKeyframe(region)) {
    if (seen.keyframe != keyframe) {
      keyframe = seen.keyframe;
      features = model->features(static_cast<std::size_t>(keyframe));
    }
    AddObservation(region, *model, features, seen, &sums);
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto num_seen = static_cast<double>(sums[i].track.size());
    if (sums[i].track.size() < 2) continue;
    model->AddPoint(region.positions_in_map[i], sums[i].error_px / num_seen, sums[i].track);
  }
}

}  // namespace nightmap
