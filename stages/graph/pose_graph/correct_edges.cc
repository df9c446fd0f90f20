// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/correct_edges.h"

#include <cmath>

#include "stages/graph/pose_graph/sensor_warnings.h"

namespace nightmap {
namespace {

// The edge between the nodes at which these poses are, seen from the edge's nodes.
PoseEdge Between(const PoseEdge& edge, const Rigid3& a_from_new_a, const Rigid3& b_from_new_b) {
  const Rigid3 new_b_from_b = b_from_new_b.Inverse();
  const Matrix6d adjoint = Adjoint(new_b_from_b);
  return {edge.frame_a,
          edge.frame_b,
          new_b_from_b * edge.b_from_a * a_from_new_a,
          adjoint * edge.covariance * adjoint.transpose(),
          edge.is_bridge};
}

class EdgeCorrector {
 public:
  EdgeCorrector(const std::vector<FrameRecord>& frames,
                const Mounting& given,
                const SensorCalibration& calibration)
      : frames_(frames), given_(given), corrected_(given) {
    if (calibration.camera_idx) {
      corrected_.robot_from_camera.at(static_cast<std::size_t>(*calibration.camera_idx)) =
          calibration.CorrectedPose();
    } else {
      corrected_.robot_from_sensor = calibration.CorrectedPose();
    }
  }

  void Remount(std::vector<PoseEdge>* edges) const {
    for (PoseEdge& edge : *edges) edge = Between(edge, Moved(edge.frame_a), Moved(edge.frame_b));
  }

 private:
  // The pose of the true camera in the one of the given mounting.
  Rigid3 Moved(int frame_idx) const {
    const int camera_idx = frames_[static_cast<std::size_t>(frame_idx)].camera_idx;
    return SensorFromCamera(given_, camera_idx).Inverse() *
           SensorFromCamera(corrected_, camera_idx);
  }

  static Rigid3 SensorFromCamera(const Mounting& mounting, int camera_idx) {
    return mounting.robot_from_sensor.Inverse() *
           mounting.robot_from_camera.at(static_cast<std::size_t>(camera_idx));
  }

  const std::vector<FrameRecord>& frames_;
  const Mounting& given_;
  Mounting corrected_;
};

// The edges measured the motion between two moments that are as much later than their frames.
void ShiftTimes(const std::vector<CameraRun>& runs,
                double later_s,
                std::vector<PoseEdge>* odometry) {
  const std::int64_t later_ns = std::llround(1e9 * later_s);
  for (PoseEdge& edge : *odometry) {
    const CameraRun* const run = RunOf(runs, edge.frame_a, edge.frame_b);
    if (!run) continue;
    const auto later_from_frame = [&](int frame_idx) {
      const StampedPose& pose = run->poses[static_cast<std::size_t>(frame_idx - run->first_frame)];
      return run->At(pose.time_ns + later_ns).Inverse() * pose.pose;
    };
    edge = Between(edge, later_from_frame(edge.frame_a), later_from_frame(edge.frame_b));
  }
}

}  // namespace

void CorrectEdges(const CalibrationWarnings& options,
                  const std::vector<FrameRecord>& frames,
                  const std::vector<CameraRun>& runs,
                  const SensorCalibration& calibration,
                  SensorGraph* sensor) {
  if (IsMountingWrong(options, calibration)) {
    const EdgeCorrector corrector(frames, *sensor->mounting, calibration);
    corrector.Remount(&sensor->odometry);
    corrector.Remount(&sensor->loops);
  }
  if (IsClockWrong(options, calibration)) {
    ShiftTimes(runs, calibration.value[kTimeIdx], &sensor->odometry);
  }
}

}  // namespace nightmap
