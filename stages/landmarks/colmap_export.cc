// SPDX-License-Identifier: Apache-2.0
#include "stages/landmarks/colmap_export.h"

namespace nightmap {
namespace {

ColmapImage MakeImage(const LandmarksInput& input,
                      DescriptorKind kind,
                      const MapKeyframe& keyframe) {
  const auto frame_idx =
      static_cast<std::size_t>(keyframe.frame_idx - input.frames.front().frame_idx);
  const FrameRecord& frame = input.frames[frame_idx];
  const FrameFeatures& features = input.features.frames[frame_idx];
  ColmapImage image;
  image.name = frame.color_path;
  image.camera_idx = frame.camera_idx;
  image.camera_from_map = keyframe.map_from_camera.Inverse();
  for (const Eigen::Vector2f& pixel : features.raw_keypoints_px) {
    image.keypoints_px.push_back(pixel.cast<double>());
  }
  image.keypoint_points.assign(image.keypoints_px.size(), -1);
  if (kind == DescriptorKind::kRootSift) image.descriptors = features.descriptors;
  return image;
}

// Adds to the track of `point` what the image sees of it.
void Observe(const Camera& camera, int image_idx, int keypoint, int point_idx, ColmapModel* model) {
  ColmapImage& image = model->images[static_cast<std::size_t>(image_idx)];
  ColmapPoint& point = model->points[static_cast<std::size_t>(point_idx)];
  const auto pixel = camera.Project(image.camera_from_map * point.position_in_map);
  if (!pixel) return;
  point.error_px += (*pixel - image.keypoints_px[static_cast<std::size_t>(keypoint)]).norm();
  point.track.push_back({image_idx, keypoint});
  image.keypoint_points[static_cast<std::size_t>(keypoint)] = point_idx;
}

}  // namespace

ColmapModel MakeColmapModel(const LandmarksInput& input, const LandmarkMap& map) {
  ColmapModel model;
  for (const RgbdCamera& camera : input.cameras) model.cameras.push_back(camera.color);
  for (const MapKeyframe& keyframe : map.keyframes) {
    model.images.push_back(MakeImage(input, map.kind, keyframe));
  }
  for (int i = 0; i < map.NumLandmarks(); ++i) {
    const auto landmark = static_cast<std::size_t>(i);
    model.points.push_back({map.positions_in_map[landmark], 0, {}});
    for (std::size_t k = 0; k < map.landmark_keyframes[landmark].size(); ++k) {
      const int image_idx = map.landmark_keyframes[landmark][k];
      const int camera_idx = model.images[static_cast<std::size_t>(image_idx)].camera_idx;
      const Camera& camera = model.cameras[static_cast<std::size_t>(camera_idx)];
      Observe(camera, image_idx, map.landmark_features[landmark][k], i, &model);
    }
    ColmapPoint& point = model.points.back();
    if (!point.track.empty()) point.error_px /= static_cast<double>(point.track.size());
  }
  return model;
}

}  // namespace nightmap
