// SPDX-License-Identifier: Apache-2.0
// An analytic scene: points with random descriptors, seen without error by known cameras.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Looks like a RootSIFT descriptor: 128 bytes of norm 512.
inline std::vector<std::uint8_t> RandomRootSift(Random& random) {
  std::vector<double> values(128);
  double sum = 0;
  for (double& value : values) {
    value = std::abs(random.Gaussian());
    sum += value * value;
  }
  std::vector<std::uint8_t> descriptor;
  for (const double value : values) {
    descriptor.push_back(
        static_cast<std::uint8_t>(std::min(255.0, std::round(512 * value / std::sqrt(sum)))));
  }
  return descriptor;
}

struct LandmarkScene {
  std::vector<Eigen::Vector3d> points_in_map;
  std::vector<std::vector<std::uint8_t>> descriptors;
  std::vector<FrameRecord> frames;
  std::vector<StampedPose> poses;  // map_from_camera
  std::vector<RgbdCamera> cameras{RgbdCamera{}};
  FeaturesShard features;
  std::vector<std::vector<int>> frame_points;  // point of each feature

  // Every point in the image is a feature, with its exact depth.
  FrameFeatures See(const Rigid3& map_from_camera, int frame_idx, std::vector<int>* seen) const {
    FrameFeatures view;
    view.frame_idx = frame_idx;
    const Rigid3 camera_from_map = map_from_camera.Inverse();
    for (std::size_t i = 0; i < points_in_map.size(); ++i) {
      const Eigen::Vector3d point = camera_from_map * points_in_map[i];
      const auto pixel = cameras[0].color.Project(point);
      if (!pixel || !cameras[0].color.Contains(*pixel)) continue;
      view.keypoints_px.push_back(pixel->cast<float>());
      view.raw_keypoints_px.push_back(pixel->cast<float>());
      view.scales_px.push_back(4.0F);
      view.depths_m.push_back(static_cast<float>(point.z()));
      view.descriptors.insert(view.descriptors.end(), descriptors[i].begin(), descriptors[i].end());
      if (seen) seen->push_back(static_cast<int>(i));
    }
    return view;
  }
};

// Makes a frame one that was tracked from another: it keeps the features that both see.
inline void TrackFrom(int reference, int frame_idx, LandmarkScene* scene) {
  const auto frame = static_cast<std::size_t>(frame_idx);
  const auto& of_reference = scene->frame_points[static_cast<std::size_t>(reference)];
  const FrameFeatures all = scene->features.frames[frame];
  FrameFeatures& tracked = scene->features.frames[frame];
  std::vector<int> points;
  tracked = FrameFeatures{};
  tracked.frame_idx = frame_idx;
  tracked.reference_frame_idx = reference;
  for (std::size_t i = 0; i < scene->frame_points[frame].size(); ++i) {
    const int point = scene->frame_points[frame][i];
    const auto found = std::ranges::lower_bound(of_reference, point);
    if (found == of_reference.end() || *found != point) continue;
    points.push_back(point);
    tracked.reference_features.push_back(static_cast<int>(found - of_reference.begin()));
    tracked.keypoints_px.push_back(all.keypoints_px[i]);
    tracked.raw_keypoints_px.push_back(all.raw_keypoints_px[i]);
    tracked.scales_px.push_back(all.scales_px[i]);
    tracked.depths_m.push_back(all.depths_m[i]);
  }
  scene->frame_points[frame] = points;
}

inline Rigid3 ScenePose(double x_m, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY())),
          {x_m, 0.1 * x_m, 0.05 * x_m}};
}

// `num_frames` cameras side by side before a cloud of points 3 to 6 m away.
inline LandmarkScene MakeLandmarkScene(int num_points = 600, int num_frames = 8) {
  LandmarkScene scene;
  Random random(7);
  for (int i = 0; i < num_points; ++i) {
    scene.points_in_map.emplace_back(
        random.Uniform(-3, 3), random.Uniform(-1.5, 1.5), random.Uniform(3, 6));
    scene.descriptors.push_back(RandomRootSift(random));
  }
  scene.cameras[0].color = Camera{640, 480, 520, 520, 319.5, 239.5};
  for (int i = 0; i < num_frames; ++i) {
    FrameRecord frame;
    frame.frame_idx = i;
    frame.time_ns = 1000000000LL * (i + 1);
    const Rigid3 pose = ScenePose(0.3 * i - 1.0, 0.1 - 0.03 * i);
    scene.frames.push_back(frame);
    scene.poses.push_back({frame.time_ns, pose});
    scene.features.frames.push_back(scene.See(pose, i, &scene.frame_points.emplace_back()));
  }
  return scene;
}

inline Vocabulary MakeSceneVocabulary(const LandmarkScene& scene) {
  std::vector<std::uint8_t> all;
  std::vector<std::vector<int>> words;
  for (const auto& d : scene.descriptors) all.insert(all.end(), d.begin(), d.end());
  Vocabulary vocabulary;
  vocabulary.tree = VocabularyTree::Train(all, DescriptorKind::kRootSift, {}, 1);
  for (const FrameFeatures& frame : scene.features.frames) {
    words.push_back(vocabulary.tree.LeafWords(frame.descriptors, 1));
  }
  vocabulary.inverted_file = InvertedFile(words);
  return vocabulary;
}

// Camera b from camera a.
inline Rigid3 TrueRelative(const LandmarkScene& scene, std::size_t a, std::size_t b) {
  return scene.poses[b].pose.Inverse() * scene.poses[a].pose;
}

// Rotation (rad) and translation (m) of the left perturbation that takes `expected` to `actual`.
inline Eigen::Matrix<double, 6, 1> LeftError(const Rigid3& actual, const Rigid3& expected) {
  const Eigen::AngleAxisd rotation(actual.rotation * expected.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = rotation.angle() * rotation.axis();
  error.tail<3>() = actual.translation - rotation.toRotationMatrix() * expected.translation;
  return error;
}

}  // namespace nightmap
