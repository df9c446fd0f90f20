// SPDX-License-Identifier: Apache-2.0
// A robot under a ceiling of points, without pictures: exact geometry, noise as stated.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/ceiling/planar_pose.h"
#include "stages/ceiling/ceiling_ekf/ceiling_ekf.h"

namespace nightmap {

struct DriveOptions {
  std::uint64_t seed = 1;
  double side_m = 12;  // of the square loop
  double path_m = 54;  // a loop and a little
  double speed_m_per_s = 0.6;
  double rate_hz = 10;
  double points_per_m2 = 6;
  double pixel_noise_px = 0.3;
  double distance_noise_m = 0.02;  // after 1 m
  double heading_noise_rad = 0.0175;
  double scale_error = 0.005;
  double heading_error_rad_per_m = 0.002;
  Eigen::Vector2d tilt_rad{0.01, -0.008};
  double vibration_rad = 0.002;
  double blank_from_m = 0, blank_to_m = 0;  // of x, on the first side: no points there
  double slip_from_s = 0, slip_to_s = 0;    // wheels report 30 % too much
  bool tiles = false;                       // points are the corners of tiles that look alike
};

struct SimulatedDrive {
  CeilingEkfInput input;
  std::vector<Rigid2> truth;  // start_from_robot at each frame
  std::vector<Rigid2> wheels;
  std::map<std::int64_t, Eigen::Vector3d> points;  // true, by track
};

// start_from_robot after `way_m` on a square with rounded corners, to the left.
inline Rigid2 OnSquare(double way_m, double side_m) {
  constexpr double kRadius_m = 0.5;
  const double straight_m = side_m - 2 * kRadius_m;
  const double arc_m = kRadius_m * std::numbers::pi / 2;
  Rigid2 pose;
  while (way_m > 0) {
    const double ahead_m = std::min(way_m, straight_m);
    pose = pose * Rigid2{0, {ahead_m, 0}};
    way_m -= ahead_m;
    const double turn_rad = std::min(way_m, arc_m) / kRadius_m;
    pose = pose *
           Rigid2{turn_rad, {kRadius_m * std::sin(turn_rad), kRadius_m * (1 - std::cos(turn_rad))}};
    way_m -= std::min(way_m, arc_m);
  }
  return pose;
}

inline std::array<std::uint8_t, 32> DescriptorOf(std::uint64_t point, std::uint64_t seed) {
  std::array<std::uint8_t, 32> descriptor{};
  Random random(seed, 77, point);
  for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(random.Next());
  return descriptor;
}

inline SimulatedDrive Simulate(const DriveOptions& options) {
  SimulatedDrive drive;
  Camera& camera = drive.input.camera.color;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 320;
  camera.cx = 319.5;
  camera.cy = 239.5;
  drive.input.camera.robot_from_camera.translation.z() = 0.35;
  const UpwardCamera upward(camera, drive.input.camera.robot_from_camera);

  Random random(options.seed, 1, 0);
  std::vector<Eigen::Vector3d> points;
  const double low = -4, high = options.side_m + 4;
  const auto is_blank = [&](const Eigen::Vector3d& p) {
    return p.x() > options.blank_from_m && p.x() < options.blank_to_m && std::abs(p.y()) < 4;
  };
  if (options.tiles) {
    for (double x = low; x < high; x += 0.6) {
      for (double y = low; y < high; y += 0.6) points.emplace_back(x, y, 2.6);
    }
  } else {
    const auto num = static_cast<int>(options.points_per_m2 * (high - low) * (high - low));
    for (int i = 0; i < num; ++i) {
      points.emplace_back(low + (high - low) * random.Uniform(),
                          low + (high - low) * random.Uniform(),
                          random.Uniform() < 0.8 ? 2.6 : 3.0);
    }
  }
  std::erase_if(points, is_blank);

  Signal& wheels = drive.input.odometry.emplace_back();
  wheels.kind = SignalKind::kOdometry;
  wheels.sensor_id = "wheels";
  const double duration_s = options.path_m / options.speed_m_per_s;
  const auto num_frames = static_cast<int>(duration_s * options.rate_hz);
  Rigid2 counted;
  std::map<std::size_t, std::pair<int, std::int64_t>> tracked;  // point -> last frame, track
  for (int i = 0; i < num_frames; ++i) {
    const double time_s = i / options.rate_hz;
    const auto time_ns = static_cast<std::int64_t>(std::llround(1e9 * (1 + time_s)));
    const Rigid2 robot = OnSquare(time_s * options.speed_m_per_s, options.side_m);
    if (i > 0) {
      const Rigid2 moved = drive.truth.back().Inverse() * robot;
      const double distance_m = moved.translation.norm();
      const bool slips = time_s > options.slip_from_s && time_s < options.slip_to_s;
      const double factor = 1 - options.scale_error + (slips ? 0.3 : 0) +
                            options.distance_noise_m * random.Gaussian() / std::sqrt(distance_m);
      const double heading_rad =
          moved.heading_rad - options.heading_error_rad_per_m * distance_m +
          options.heading_noise_rad * std::sqrt(distance_m) * random.Gaussian();
      counted = counted * Rigid2{heading_rad, factor * moved.translation};
    }
    drive.truth.push_back(robot);
    drive.wheels.push_back(counted);
    wheels.samples.push_back({time_ns, ToVector(counted), {}});

    TrackedFrame& frame = drive.input.tracks.frames.emplace_back();
    frame.time_ns = time_ns;
    frame.frame_idx = i;
    const Eigen::Vector2d tilt_rad =
        options.tilt_rad +
        options.vibration_rad * Eigen::Vector2d(random.Gaussian(), random.Gaussian());
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double away_m = (points[j].head<2>() - robot.translation).norm();
      if (away_m > 4) continue;
      const auto seen = upward.Project(ToVector(robot), tilt_rad, points[j]);
      if (!seen || !camera.Contains(seen->pixel)) continue;
      const auto before = tracked.find(j);
      std::int64_t track_id = MakeTrackId(i, static_cast<int>(j));
      if (before != tracked.end() && before->second.first == i - 1)
        track_id = before->second.second;
      if (FirstFrameOf(track_id) == i) {
        drive.points[track_id] = points[j];
        drive.input.tracks.descriptors.push_back(
            {track_id, DescriptorOf(options.tiles ? 0 : j, options.seed)});
      }
      tracked[j] = {i, track_id};
      const Eigen::Vector2d noise(random.Gaussian(), random.Gaussian());
      const Eigen::Vector2f pixel = (seen->pixel + options.pixel_noise_px * noise).cast<float>();
      frame.sightings.push_back({track_id, pixel, pixel});
    }
    std::ranges::sort(frame.sightings, {}, &CornerSighting::track_id);
  }
  std::ranges::sort(drive.input.tracks.descriptors, {}, &TrackDescriptor::track_id);
  return drive;
}

}  // namespace nightmap
