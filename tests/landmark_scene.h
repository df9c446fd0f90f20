// SPDX-License-Identifier: Apache-2.0
// An analytic scene: points with random descriptors, seen without error by known cameras.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/camera/verify_pairs.h"
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

  FramesWithFeatures Input() const { return {frames, cameras, SiteFeatures(features)}; }

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

// The features that show the same point.
inline std::vector<FeatureMatch> CommonPoints(const LandmarkScene& scene, int a, int b) {
  const auto& points_a = scene.frame_points[static_cast<std::size_t>(a)];
  const auto& points_b = scene.frame_points[static_cast<std::size_t>(b)];
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < points_a.size(); ++i) {
    const auto found = std::ranges::lower_bound(points_b, points_a[i]);
    if (found == points_b.end() || *found != points_a[i]) continue;
    matches.push_back({static_cast<int>(i), static_cast<int>(found - points_b.begin())});
  }
  return matches;
}

// Makes a frame one that was tracked from another: it keeps the features that both see.
inline void TrackFrom(int reference, int frame_idx, LandmarkScene* scene) {
  const auto frame = static_cast<std::size_t>(frame_idx);
  const FrameFeatures all = scene->features.frames[frame];
  FrameFeatures& tracked = scene->features.frames[frame];
  std::vector<int> points;
  tracked = FrameFeatures{};
  tracked.frame_idx = frame_idx;
  tracked.reference_frame_idx = reference;
  for (const FeatureMatch& match : CommonPoints(*scene, frame_idx, reference)) {
    const auto i = static_cast<std::size_t>(match.a);
    points.push_back(scene->frame_points[frame][i]);
    tracked.reference_features.push_back(match.b);
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

// The next frame, a second later.
inline void AddFrame(const Rigid3& pose, LandmarkScene* scene) {
  const int idx = static_cast<int>(scene->frames.size());
  const std::int64_t time_ns = 1000000000LL * (idx + 1);
  scene->frames.push_back({idx, time_ns, 0, 0, {}, {}, {}});
  scene->poses.push_back({time_ns, pose});
  scene->features.frames.push_back(scene->See(pose, idx, &scene->frame_points.emplace_back()));
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
    AddFrame(ScenePose(0.3 * i - 1.0, 0.1 - 0.03 * i), &scene);
  }
  return scene;
}

// The same way once more, in the same frames with other numbers.
inline void GoAgain(LandmarkScene* scene) {
  const std::size_t num_out = scene->frames.size();
  for (std::size_t i = 0; i < num_out; ++i) {
    const int idx = static_cast<int>(num_out + i);
    scene->frames.push_back(scene->frames[i]);
    scene->frames.back().frame_idx = idx;
    scene->features.frames.push_back(scene->features.frames[i]);
    scene->features.frames.back().frame_idx = idx;
  }
}

// The tree of all descriptors, and the words of each frame's.
inline Vocabulary VocabularyOf(const std::vector<std::uint8_t>& all,
                               const std::vector<FrameFeatures>& frames) {
  Vocabulary vocabulary;
  vocabulary.tree = VocabularyTree::Train(all, DescriptorKind::kRootSift, {}, 1);
  for (const FrameFeatures& frame : frames) {
    vocabulary.words.push_back(vocabulary.tree.LeafWords(frame.descriptors, 1));
  }
  return vocabulary;
}

inline VocabularyIndex IndexOf(const Vocabulary& vocabulary) {
  return {vocabulary.tree, InvertedFile(vocabulary.words)};
}

inline Vocabulary MakeSceneVocabulary(const LandmarkScene& scene) {
  std::vector<std::uint8_t> all;
  for (const auto& d : scene.descriptors) all.insert(all.end(), d.begin(), d.end());
  return VocabularyOf(all, scene.features.frames);
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
