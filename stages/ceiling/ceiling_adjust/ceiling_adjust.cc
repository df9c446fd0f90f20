// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_adjust.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "pipeline/base/input_error.h"
#include "pipeline/ceiling/planar_pose.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/wheel_motion.h"
#include "stages/ceiling/ceiling_adjust/adjusted_frames.h"

namespace nightmap {
namespace {

constexpr double kKeyframeTurn_rad = 0.1;  // turn between keyframes
constexpr int kMinKeyframes = 3;           // that see a landmark
constexpr double kLevelSpread_m = 0.03;    // points so near a height are at that level
constexpr double kSizeWarning_sigmas = 3;

Rigid2 InPlane(const Rigid3& pose) {
  const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitX();
  return {std::atan2(ahead.y(), ahead.x()), pose.translation.head<2>()};
}

std::vector<Rigid2> PosesOf(const CeilingAdjustInput& input) {
  const auto is_same = [](const CeilingFrame& frame, const StampedPose& pose) {
    return frame.time_ns == pose.time_ns;
  };
  if (!std::ranges::equal(input.map.frames, input.trajectory, is_same)) {
    throw InputError({{"trajectory"}, {"map"}},
                     InputError::Remedy::kDelete,
                     "times of trajectory and map differ");
  }
  std::vector<Rigid2> poses;
  for (const StampedPose& pose : input.trajectory) poses.push_back(InPlane(pose.pose));
  return poses;
}

// Landmark by each track that saw it.
std::map<std::int64_t, std::size_t> LandmarkOfTrack(const CeilingMap& map) {
  std::map<std::int64_t, std::size_t> landmark_of;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    landmark_of[map.landmarks[i].track_id] = i;
  }
  for (const MetAgain& met : map.met_again) {
    landmark_of[met.track_id] = landmark_of.at(met.landmark_track_id);
  }
  return landmark_of;
}

std::vector<KeyframeMotion> MotionsBetween(const CeilingAdjustOptions& options,
                                           const Signal& wheels,
                                           const std::vector<CeilingFrame>& frames,
                                           const std::vector<Rigid2>& poses,
                                           const std::vector<std::size_t>& keyframes) {
  std::vector<KeyframeMotion> motions;
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    const std::size_t a = keyframes[k - 1], b = keyframes[k];
    const auto measured = MotionBetween(
        wheels.samples, options.odometry.max_gap_s, frames[a].time_ns, frames[b].time_ns);
    const bool has_slipped =
        std::any_of(frames.begin() + static_cast<std::ptrdiff_t>(a) + 1,
                    frames.begin() + static_cast<std::ptrdiff_t>(b) + 1,
                    [](const CeilingFrame& frame) { return frame.has_slipped; });
    KeyframeMotion& motion = motions.emplace_back();
    motion.start = k - 1;
    motion.time_s = static_cast<double>(frames[b].time_ns - frames[a].time_ns) * 1e-9;
    motion.is_measured = measured && !has_slipped;
    motion.before_from_after = poses[a].Inverse() * poses[b];
    if (motion.is_measured) {
      const Rigid3 robot_from_wheels = wheels.robot_from_sensor;
      motion.before_from_after =
          InPlane(robot_from_wheels * measured->start_from_end * robot_from_wheels.Inverse());
      motion.distance_m = measured->distance_m;
      motion.turn_rad = measured->turn_rad;
    }
  }
  return motions;
}

// Points at the height at which most are.
std::vector<std::size_t> MainLevel(const std::vector<Eigen::Vector3d>& points) {
  std::vector<std::pair<double, std::size_t>> heights;
  for (std::size_t i = 0; i < points.size(); ++i) heights.emplace_back(points[i].z(), i);
  std::ranges::sort(heights);
  std::size_t best_first = 0, best_end = 0, end = 0;
  for (std::size_t first = 0; first < heights.size(); ++first) {
    while (end < heights.size() &&
           heights[end].first <= heights[first].first + 2 * kLevelSpread_m) {
      ++end;
    }
    if (end - first > best_end - best_first) best_first = first, best_end = end;
  }
  std::vector<std::size_t> level;
  for (std::size_t i = best_first; i < best_end; ++i) level.push_back(heights[i].second);
  return level;
}

double MeanHeight_m(const std::vector<Eigen::Vector3d>& points,
                    const std::vector<std::size_t>& level) {
  double sum_m = 0;
  for (const std::size_t point : level) sum_m += points[point].z();
  return level.empty() ? 0 : sum_m / static_cast<double>(level.size());
}

class CeilingAdjuster {
 public:
  CeilingAdjuster(const CeilingAdjustOptions& options, const CeilingAdjustInput& input)
      : options_(options),
        input_(input),
        poses_(PosesOf(input)),
        keyframes_(ChooseKeyframes(poses_, options.keyframe_distance_m, kKeyframeTurn_rad)) {
    problem_.camera = input.camera.color;
    problem_.robot_from_camera = input.camera.robot_from_camera;
    const Signal& wheels =
        ChooseOdometry(input.odometry, options.odometry.sensor, "ceiling_adjust.odometry_sensor");
    problem_.motions = MotionsBetween(options, wheels, input.map.frames, poses_, keyframes_);
    for (const std::size_t frame : keyframes_) {
      Vector5d& keyframe = unknowns_.keyframes.emplace_back(Vector5d::Zero());
      keyframe.head<3>() = ToVector(poses_[frame]);
    }
    AddSightings();
    level_ = MainLevel(unknowns_.points);
    unknowns_.level_m = MeanHeight_m(unknowns_.points, level_);
    if (options.ceiling_height_m > 0) {
      problem_.level = {options.ceiling_height_m, options.ceiling_height_sigma_m, level_};
    }
  }

  CeilingAdjustResult Run(Progress& progress) {
    CeilingAdjustResult result;
    result.solution = SolveCeiling(options_.noise, problem_, progress, &unknowns_);
    result.num_keyframes = static_cast<int>(keyframes_.size());
    result.num_sightings = static_cast<int>(problem_.sightings.size());
    result.num_guessed_motions =
        static_cast<int>(std::ranges::count(problem_.motions, false, &KeyframeMotion::is_measured));
    result.mounting = unknowns_.mounting;
    result.wheels = unknowns_.wheels;
    result.level_m = MeanHeight_m(unknowns_.points, level_);
    Describe(&result.map);
    return result;
  }

 private:
  void AddSightings() {
    const std::vector<PointSighting> all = SightingsOfLandmarks();
    std::vector<int> num_keyframes(input_.map.landmarks.size());
    for (const PointSighting& sighting : all) ++num_keyframes[sighting.point];
    std::map<std::size_t, std::size_t> point_of;
    for (std::size_t i = 0; i < num_keyframes.size(); ++i) {
      if (num_keyframes[i] < kMinKeyframes) continue;
      point_of[i] = landmarks_.size();
      landmarks_.push_back(i);
      unknowns_.points.push_back(input_.map.landmarks[i].position_m);
    }
    if (landmarks_.empty()) {
      throw InputError({{"map"}},
                       InputError::Remedy::kInText,
                       "no landmark is seen by {} keyframes; lower "
                       "ceiling_adjust.keyframe_distance_m, or see what the pictures show",
                       kMinKeyframes);
    }
    for (PointSighting sighting : all) {
      const auto point = point_of.find(sighting.point);
      if (point == point_of.end()) continue;
      sighting.point = point->second;
      problem_.sightings.push_back(sighting);
    }
  }

  // `point` of these is the index of the filter's landmark.
  std::vector<PointSighting> SightingsOfLandmarks() const {
    const std::map<std::int64_t, std::size_t> landmark_of = LandmarkOfTrack(input_.map);
    std::map<std::int64_t, std::size_t> keyframe_at;
    for (std::size_t k = 0; k < keyframes_.size(); ++k) {
      keyframe_at[input_.map.frames[keyframes_[k]].time_ns] = k;
    }
    std::vector<PointSighting> sightings;
    for (const TrackedFrame& frame : input_.tracks.frames) {
      const auto keyframe = keyframe_at.find(frame.time_ns);
      if (keyframe == keyframe_at.end()) continue;
      for (const CornerSighting& sighting : frame.sightings) {
        const auto landmark = landmark_of.find(sighting.track_id);
        if (landmark == landmark_of.end()) continue;
        sightings.push_back({keyframe->second, landmark->second, sighting.px.cast<double>()});
      }
    }
    return sightings;
  }

  void Describe(CeilingMap* map) const {
    *map = input_.map;
    map->mounting = unknowns_.mounting;
    std::vector<Rigid2> adjusted;
    for (const Vector5d& keyframe : unknowns_.keyframes) {
      adjusted.push_back(ToRigid2(keyframe.head<3>()));
    }
    std::vector<std::int64_t> times_ns;
    for (const CeilingFrame& frame : map->frames) times_ns.push_back(frame.time_ns);
    const std::vector<Rigid2> carried = CarryFrames(poses_, times_ns, keyframes_, adjusted);
    for (std::size_t i = 0; i < carried.size(); ++i) map->frames[i].map_from_robot = carried[i];
    map->landmarks.clear();
    std::map<std::int64_t, bool> is_kept;
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      CeilingLandmark landmark = input_.map.landmarks[landmarks_[i]];
      landmark.position_m = unknowns_.points[i];
      map->landmarks.push_back(landmark);
      is_kept[landmark.track_id] = true;
    }
    std::erase_if(map->met_again,
                  [&](const MetAgain& met) { return !is_kept.contains(met.landmark_track_id); });
  }

  const CeilingAdjustOptions& options_;
  const CeilingAdjustInput& input_;
  std::vector<Rigid2> poses_;           // of the filter, by frame
  std::vector<std::size_t> keyframes_;  // frames
  std::vector<std::size_t> landmarks_;  // of the filter, by point
  std::vector<std::size_t> level_;      // points
  CeilingProblem problem_;
  CeilingUnknowns unknowns_;
};

// Wheels or a mounting that are as wrong as nearly none should be.
void Warn(const CeilingNoise& noise, const CeilingAdjustResult& result) {
  if (std::abs(result.wheels.x()) > kSizeWarning_sigmas * noise.scale_sigma) {
    spdlog::warn(
        "distances of the wheels seem wrong by {:.1f} %: check their calibration, the height of "
        "the camera in robot_from_camera, and ceiling_adjust.ceiling_height_m",
        100 * result.wheels.x());
  }
  if (result.mounting.head<3>().norm() > kSizeWarning_sigmas * noise.mounting_tilt_sigma_rad) {
    spdlog::warn(
        "the camera is turned by {:.1f}, {:.1f}, {:.1f} deg about its axes against "
        "robot_from_camera: correct it in the site config",
        result.mounting[0] * 180 / std::numbers::pi,
        result.mounting[1] * 180 / std::numbers::pi,
        result.mounting[2] * 180 / std::numbers::pi);
  }
}

}  // namespace

CeilingAdjustResult RunCeilingAdjust(const CeilingAdjustOptions& options,
                                     const CeilingAdjustInput& input,
                                     Progress& progress) {
  const CeilingAdjustResult result = CeilingAdjuster(options, input).Run(progress);
  Warn(options.noise, result);
  return result;
}

}  // namespace nightmap
