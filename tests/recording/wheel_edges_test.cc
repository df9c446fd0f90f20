// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_edges.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "tests/test_data.h"

namespace nightmap::wheel_edges_test {

constexpr std::int64_t kSamplePeriod_ns = 40'000'000;
constexpr std::int64_t kFramePeriod_ns = 100'000'000;
constexpr int kNumSamples = 200;  // 8 s

// Motion at constant speed: straight, on a circle, or turning on the spot.
struct Drive {
  double speed_m_per_s;
  double turn_rad_per_s;
};
constexpr Drive kDrives[] = {{0.7, 0}, {0.7, 0.9}, {-0.5, -2.5}, {0, 1.3}, {0, 0}};

// x, y, heading of the wheels.
Eigen::Vector3d WheelsAt(const Drive& drive, std::int64_t time_ns) {
  const double time_s = 1e-9 * static_cast<double>(time_ns);
  const double heading = drive.turn_rad_per_s * time_s;
  if (drive.turn_rad_per_s == 0) return {drive.speed_m_per_s * time_s, 0, 0};
  const double radius_m = drive.speed_m_per_s / drive.turn_rad_per_s;
  return {radius_m * std::sin(heading), radius_m * (1 - std::cos(heading)), heading};
}

Rigid3 PoseOf(const Eigen::Vector3d& value) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(value.z(), Eigen::Vector3d::UnitZ())),
          {value.x(), value.y(), 0}};
}

// Wheels whose frame is neither at the robot's origin nor along its axes.
Signal Wheels(const Drive& drive) {
  Signal wheels{SignalKind::kOdometry,
                "wheels",
                {Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, 3).normalized())),
                 {-0.1, 0.05, 0.2}},
                {}};
  for (int i = 0; i < kNumSamples; ++i) {
    const std::int64_t time_ns = i * kSamplePeriod_ns;
    wheels.samples.push_back({time_ns, WheelsAt(drive, time_ns), {}});
  }
  return wheels;
}

// Two cameras off the centre: one looks ahead and down, one to the side.
std::vector<RgbdCamera> Cameras() {
  std::vector<RgbdCamera> cameras(2);
  const Eigen::Quaterniond ahead(0.5, -0.5, 0.5, -0.5);
  const Eigen::Quaterniond down(Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond aside(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ()));
  cameras[0].robot_from_camera = {ahead * down, {0.3, -0.2, 1.1}};
  cameras[1].robot_from_camera = {aside * ahead, {-0.4, 0.1, 0.7}};
  return cameras;
}

// Between samples and at them, from 0.01 s on.
std::vector<FrameRecord> Frames(int count = 70) {
  std::vector<FrameRecord> frames(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    FrameRecord& frame = frames[static_cast<std::size_t>(i)];
    frame.frame_idx = i;
    frame.time_ns = 10'000'000 + i * kFramePeriod_ns;
  }
  return frames;
}

Rigid3 TruePose(const Drive& drive, const FrameRecord& frame) {
  const Rigid3 wheels_from_robot = Wheels(drive).robot_from_sensor.Inverse();
  return PoseOf(WheelsAt(drive, frame.time_ns)) * wheels_from_robot *
         Cameras()[static_cast<std::size_t>(frame.camera_idx)].robot_from_camera;
}

void ExpectExact(const Drive& drive, const std::vector<FrameRecord>& frames) {
  const SensorEdges edges = WheelEdges({}, frames, Cameras(), Wheels(drive));
  EXPECT_EQ(edges.sensor, "wheels");
  ASSERT_TRUE(edges.mounting.has_value());
  EXPECT_EQ(edges.mounting->robot_from_sensor.Matrix(), Wheels(drive).robot_from_sensor.Matrix());
  EXPECT_EQ(edges.mounting->robot_from_camera.size(), Cameras().size());
  ASSERT_EQ(edges.edges.size(), frames.size() - 1);
  for (std::size_t i = 0; i < edges.edges.size(); ++i) {
    const SensorEdge& edge = edges.edges[i];
    EXPECT_EQ(edge.kind, EdgeKind::kOdometry);
    EXPECT_EQ(edge.source_time_ns, frames[i].time_ns);
    EXPECT_EQ(edge.target_time_ns, frames[i + 1].time_ns);
    const Rigid3 truth = TruePose(drive, frames[i + 1]).Inverse() * TruePose(drive, frames[i]);
    EXPECT_LT((edge.target_from_source.translation - truth.translation).norm(), 1e-12);
    EXPECT_LT(AngleBetween_rad(edge.target_from_source, truth), 1e-7);  // of an arc cosine
  }
}

TEST(WheelEdges, StraightAndCircularMotionIsExactForAnyMounting) {
  for (const Drive& drive : kDrives) ExpectExact(drive, Frames());
}

TEST(WheelEdges, FramesOfDifferentCamerasAreJoined) {
  std::vector<FrameRecord> frames = Frames();
  for (FrameRecord& frame : frames) frame.camera_idx = frame.frame_idx % 2;
  for (const Drive& drive : kDrives) ExpectExact(drive, frames);
}

TEST(WheelEdges, FramesBetweenTwoSamplesAndAtTheirTimesAreExact) {
  std::vector<FrameRecord> frames = Frames(5);
  const std::int64_t times_ns[] = {0, 10'000'000, 30'000'000, 40'000'000, 199 * kSamplePeriod_ns};
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].time_ns = times_ns[i];
  for (const Drive& drive : kDrives) ExpectExact(drive, frames);
}

TEST(WheelEdges, AWrappedHeadingIsNoTurn) {
  const Drive circle = {0.7, 0.9};
  Signal wrapped = Wheels(circle);
  for (SignalSample& sample : wrapped.samples) {
    sample.value.z() = std::remainder(sample.value.z(), 2 * std::numbers::pi);
  }
  const SensorEdges a = WheelEdges({}, Frames(), Cameras(), Wheels(circle));
  const SensorEdges b = WheelEdges({}, Frames(), Cameras(), wrapped);
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_TRUE(a.edges[i].target_from_source.Matrix().isApprox(
        b.edges[i].target_from_source.Matrix(), 1e-12));
    EXPECT_TRUE(a.edges[i].covariance.isApprox(b.edges[i].covariance, 1e-9));
  }
}

TEST(WheelEdges, TheEdgesAreAFileThatIsRead) {
  const TemporaryFolder folder;
  for (const Drive& drive : kDrives) {
    const SensorEdges edges = WheelEdges({}, Frames(), Cameras(), Wheels(drive));
    WriteEdges(folder / "edges.h5", edges, "");  // the reader checks the covariances
    EXPECT_EQ(ReadEdges(folder / "edges.h5").edges.size(), edges.edges.size());
  }
}

// The covariance of the first edge, in the frame of the wheels at its end.
Matrix6d CovarianceOfWheels(const WheelNoise& noise, const Drive& drive) {
  const auto frames = Frames(2);
  const Matrix6d covariance =
      WheelEdges(noise, frames, Cameras(), Wheels(drive)).edges[0].covariance;
  EXPECT_EQ(covariance.llt().info(), Eigen::Success);
  const Matrix6d to_wheels =
      Adjoint(Wheels(drive).robot_from_sensor.Inverse() * Cameras()[0].robot_from_camera);
  return to_wheels * covariance * to_wheels.transpose();
}

TEST(WheelEdges, TheCovarianceIsTheNoiseOfTheWheelsAsTheCameraSeesIt) {
  const WheelNoise noise;
  const double distance_m = 0.07, turn_rad = 0.09;  // between two frames
  const double position_m = 0.002 + 0.05 * distance_m + 0.01 * turn_rad;
  const double heading_rad = 0.002 + 0.02 * distance_m + 0.05 * turn_rad;
  Vector6d sigma;
  sigma << 0.01, 0.01, heading_rad, position_m, position_m, 0.005;
  const Matrix6d expected = sigma.cwiseAbs2().asDiagonal();
  for (const Drive& drive : {Drive{0.7, 0.9}, Drive{-0.7, -0.9}}) {
    EXPECT_LT((CovarianceOfWheels(noise, drive) - expected).cwiseAbs().maxCoeff(), 1e-12);
  }
}

// A camera far ahead of the axle moves sideways when the wheels turn more than they say.
TEST(WheelEdges, AnErrorOfTheHeadingMovesACameraThatIsOffTheAxle) {
  const WheelNoise noise;
  Signal wheels = Wheels({0, 0});
  wheels.robot_from_sensor = {};
  std::vector<RgbdCamera> cameras(1);
  cameras[0].robot_from_camera.translation = {2, 0, 0};  // with the axes of the wheels
  const Matrix6d covariance = WheelEdges(noise, Frames(2), cameras, wheels).edges[0].covariance;
  const double heading2 = std::pow(noise.heading_sigma_floor_rad, 2);
  const double position2 = std::pow(noise.position_sigma_floor_m, 2);
  EXPECT_NEAR(covariance(2, 2), heading2, 1e-15);
  EXPECT_NEAR(covariance(3, 3), position2, 1e-15);
  EXPECT_NEAR(covariance(4, 4), position2 + 4 * heading2, 1e-15);
}

TEST(WheelEdges, FramesOutsideOfTheSamplesAndAroundAGapHaveNoEdge) {
  const Drive drive = kDrives[1];
  Signal wheels = Wheels(drive);
  const auto times_of = [&](const Signal& signal) {
    std::vector<std::int64_t> times_ns;
    for (const SensorEdge& edge : WheelEdges({}, Frames(90), Cameras(), signal).edges) {
      times_ns.push_back(edge.source_time_ns);
    }
    return times_ns;
  };
  EXPECT_EQ(times_of(wheels).back(), 7'810'000'000);  // the last sample is at 7.96 s
  std::erase_if(wheels.samples, [](const SignalSample& sample) {
    return sample.time_ns < 1'000'000'000 ||
           (sample.time_ns > 3'000'000'000 && sample.time_ns < 3'450'000'000) ||
           (sample.time_ns > 5'000'000'000 && sample.time_ns < 5'600'000'000);
  });
  const auto times_ns = times_of(wheels);  // samples begin at 1 s; 3 to 3.48 is no gap, 5 to 5.6 is
  EXPECT_EQ(times_ns.front(), 1'010'000'000);
  EXPECT_TRUE(std::ranges::count(times_ns, 3'210'000'000));
  EXPECT_TRUE(std::ranges::count(times_ns, 4'810'000'000));
  for (std::int64_t t = 4'910'000'000; t < 5'600'000'000; t += kFramePeriod_ns) {
    EXPECT_FALSE(std::ranges::count(times_ns, t)) << t;
  }
  EXPECT_TRUE(std::ranges::count(times_ns, 5'610'000'000));
  wheels.samples.clear();
  EXPECT_TRUE(times_of(wheels).empty());
}

TEST(WheelEdges, NoEdgeLeadsFromOneRecordingToAnother) {
  std::vector<FrameRecord> frames = Frames(10);
  for (FrameRecord& frame : frames) frame.sequence_idx = frame.frame_idx / 5;
  const SensorEdges edges = WheelEdges({}, frames, Cameras(), Wheels(kDrives[0]));
  EXPECT_EQ(edges.edges.size(), 8U);
  for (const SensorEdge& edge : edges.edges) EXPECT_NE(edge.source_time_ns, frames[4].time_ns);
}

}  // namespace nightmap::wheel_edges_test
