// SPDX-License-Identifier: Apache-2.0
// The state of EKF-SLAM under a ceiling, and the operations on it: where the robot is, what is
// wrong with its wheels and its camera, and the landmarks in view.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/ceiling/ceiling_noise.h"
#include "pipeline/geometry/rigid2.h"
#include "stages/ceiling/ceiling_ekf/ceiling_state.h"
#include "stages/ceiling/ceiling_ekf/compressed_ekf.h"
#include "stages/ceiling/ceiling_ekf/upward_camera.h"

namespace nightmap {

// The robot's motion from one frame to the next.
struct ControlInput {
  Rigid2 before_from_after;
  double distance_m = 0;      // along the way
  double turn_rad = 0;        // of all turns, left or right
  double unknown_time_s = 0;  // for which nothing measured it
};

// One landmark of the active state, in the frame of the anchor.
struct ActiveLandmark {
  std::int64_t track_id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// A pixel at which a landmark was seen.
struct LandmarkSighting {
  std::int64_t track_id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

// Everything near is in the frame of an anchor, the place of the robot some metres ago, and only
// the anchor's pose is in the map (robocentric mapping: Castellanos, Martinez-Cantin, Tardos,
// Neira, Robocentric map joining, Robotics and Autonomous Systems 55(1), 2007). So what is seen
// says nothing of the map's heading, linearization is about small angles, and the filter stays
// consistent. Anchors that were left are kept states of the compressed filter; their landmarks are
// no states any more.
//
// ceiling_state.h has the layout of the active state. The map's frame is the robot's at the start.
// Deterministic; one thread.
class CeilingFilter {
 public:
  CeilingFilter(const UpwardCamera& camera, const CeilingNoise& noise);

  // Differential drive: an arc, with the errors of the state and of CeilingNoise.
  void Predict(const ControlInput& input);
  // The last motion is not what the wheels say: adds this uncertainty to the robot's pose, in its
  // own axes (m, m, rad).
  void Loosen(const Eigen::Vector3d& sigma);

  // Fit of sightings: chi-square of each alone, two degrees of freedom. Infinite for a landmark
  // that cannot be seen there, or is none.
  std::vector<double> Gates(const std::vector<LandmarkSighting>& sightings) const;
  // Joint update. Sightings of tracks that are no landmarks are not used.
  Innovation Observe(const std::vector<LandmarkSighting>& sightings);
  // Those whose pixel lies within so many sigmas of what the state says now, on both axes.
  std::vector<LandmarkSighting> Agreeing(const std::vector<LandmarkSighting>& sightings,
                                         double max_sigmas) const;
  // Chi-square, three degrees of freedom, of the robot's pose in `after` by what this filter,
  // before an update, expected of it.
  double Surprise(const CeilingFilter& after) const;

  // Remembers the robot's pose and vibration of now: a view from which corners are seen. Returns
  // its id, which grows.
  std::int64_t AddClone();
  void RemoveClones(const std::vector<std::int64_t>& clone_ids);
  // Adds the landmark that was seen at `from` in a clone and is seen at `now`. The depth enters by
  // the second ray alone. False, and nothing is added, when the two rays meet at less than
  // `min_parallax_rad`, or pass each other so far that the chi-square of the second pixel, two
  // degrees of freedom, is `gate`.
  bool AddLandmark(std::int64_t track_id,
                   std::int64_t clone_id,
                   const Eigen::Vector2d& from,
                   const Eigen::Vector2d& now,
                   double min_parallax_rad,
                   double gate);
  // The same as CN103680291A adds it: at the depth of its disparity (disparity_depth.h) on the ray
  // of `now`, which is not observed once more. False for a disparity within three of its
  // deviations.
  bool AddLandmarkByDisparity(std::int64_t track_id,
                              std::int64_t clone_id,
                              const Eigen::Vector2d& from,
                              const Eigen::Vector2d& now);
  void RemoveLandmarks(const std::vector<std::int64_t>& track_ids);
  std::vector<ActiveLandmark> Landmarks() const;

  // The robot's place becomes the anchor; the old one is kept.
  void MoveAnchor();
  int NumAnchors() const { return static_cast<int>(filter_.NumKept()) / 3 + 1; }
  // Anchors count from 0; the last is the active one.
  Rigid2 MapFromAnchor(int anchor);
  // Covariances of x, y, heading: of an anchor in the map, and of one seen from the last.
  Eigen::Matrix3d AnchorCovariance(int anchor);
  Eigen::Matrix3d RelativeCovariance(int anchor);
  // Measured: last_from_anchor, with the covariance of x, y, heading.
  Innovation CloseLoop(int anchor,
                       const Rigid2& last_from_anchor,
                       const Eigen::Matrix3d& covariance);

  // The standard deviation of the wheels' distance after a way.
  double WheelSigma_m(double distance_m) const;

  Rigid2 AnchorFromRobot() const;
  Rigid2 MapFromRobot() const;
  Eigen::Matrix3d RobotCovariance() const;  // in the map
  Eigen::Vector2d MountingTilt_rad() const { return filter_.Active().segment<2>(kMounting); }
  double HeadingError_rad_per_m() const { return filter_.Active()[kHeadingError]; }

 private:
  struct Part {
    std::int64_t id = 0;
    Eigen::Index first = 0;
    // A landmark's place, or a clone's pose, as it was first estimated. Derivatives are taken
    // there.
    Eigen::Vector3d linearized_at = Eigen::Vector3d::Zero();
  };
  const Part* FindLandmark(std::int64_t track_id) const;
  const Part& FindClone(std::int64_t clone_id) const;
  void Insert(const Part& landmark);
  // Takes the parts with these ids away, and their states of this size.
  void Remove(const std::vector<std::int64_t>& ids, Eigen::Index size, std::vector<Part>* parts);
  std::optional<UpwardCamera::Projection> Expect(const Part& landmark) const;
  // Leaves out sightings of what is no landmark or cannot be seen there; `measured` receives the
  // indices of the others.
  Measurement Measure(const std::vector<LandmarkSighting>& sightings,
                      std::vector<std::size_t>* measured = nullptr) const;

  UpwardCamera camera_;
  CeilingNoise noise_;
  CompressedEkf filter_;
  Eigen::Vector3d robot_linearized_at_ = Eigen::Vector3d::Zero();  // the prediction of its pose
  std::vector<Part> clones_;
  std::vector<Part> landmarks_;  // ascending id
  std::int64_t next_clone_id_ = 0;
  double unknown_since_s_ = 0;  // time without odometry until now
};

}  // namespace nightmap
