// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/frames/robot_truth.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/time_unit.h"

namespace nightmap {
namespace {

constexpr double kMaxTruthDistance_m = 1e7;  // or rad

std::filesystem::path PathOf(const SiteConfig& site,
                             const std::filesystem::path& data_root,
                             const std::string& file) {
  return data_root / (std::filesystem::path(site.root) / file).lexically_normal();
}

// The frame in which the wheels start is that of the truth.
std::vector<StampedPose> PosesOf(const Signal& odometry) {
  const Rigid3 sensor_from_robot = odometry.robot_from_sensor.Inverse();
  std::vector<StampedPose> poses;
  for (const SignalSample& sample : odometry.samples) {
    const Eigen::AngleAxisd turn(sample.value[2], Eigen::Vector3d::UnitZ());
    const Rigid3 truth_from_sensor{Eigen::Quaterniond(turn), {sample.value[0], sample.value[1], 0}};
    poses.push_back({sample.time_ns, truth_from_sensor * sensor_from_robot});
  }
  return poses;
}

std::vector<StampedPose> TakeOdometry(const RobotTruthConfig& config,
                                      std::vector<Signal>* signals) {
  const auto found = std::ranges::find(*signals, config.odometry, &Signal::sensor_id);
  if (found == signals->end() || found->samples.empty()) {
    throw DataError(
        "{}: the sensor \"{}\" has no sample: add its [[signal]]", config.source, config.odometry);
  }
  std::vector<StampedPose> poses = PosesOf(*found);
  signals->erase(found);
  return poses;
}

std::vector<StampedPose> ReadTrajectory(const std::filesystem::path& path,
                                        const RobotTruthConfig& config) {
  if (config.time_unit.empty()) {
    DemandSeconds(UnitLike(path, kMaxFrameStep_s), path, config.source);
  }
  std::vector<StampedPose> poses = ReadTum(path, UnitOf(config.time_unit));
  if (!poses.empty()) return poses;
  throw DataError("{}: holds no pose: correct `trajectory` in {}", path.string(), config.source);
}

void CheckRelation(const std::vector<std::string_view>& words) {
  if (words.size() != 8) {
    throw DataError("{} columns, expected 8 (time1 time2 x y z roll pitch yaw)", words.size());
  }
  for (std::size_t i = 0; i < 2; ++i) CheckedTime_ns(ParseTime_ns(words[i]));
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (std::abs(RealWord(words[i])) > kMaxTruthDistance_m)
      throw DataError("{} is too far", words[i]);
  }
}

// Returns the number of relations in a file.
std::size_t CheckRelations(const std::filesystem::path& path, const RobotTruthConfig& config) {
  std::size_t count = 0;
  try {
    VisitWordLines(path, [&](const std::vector<std::string_view>& words) {
      CheckRelation(words);
      ++count;
    });
  } catch (const DataError& error) {
    throw DataError(
        "{}: repair the file or correct `relations` in {}", error.what(), config.source);
  }
  if (count > 0) return count;
  throw DataError("{}: holds no relation: correct `relations` in {}", path.string(), config.source);
}

}  // namespace

RobotTruth TakeRobotTruth(const SiteConfig& site,
                          const std::filesystem::path& data_root,
                          std::vector<Signal>* signals) {
  const RobotTruthConfig& config = site.robot_truth;
  RobotTruth truth;
  if (!config.odometry.empty()) truth.truth_from_robot = TakeOdometry(config, signals);
  if (!config.trajectory.empty()) {
    truth.truth_from_robot = ReadTrajectory(PathOf(site, data_root, config.trajectory), config);
  }
  if (!config.relations.empty()) {
    const std::filesystem::path path = PathOf(site, data_root, config.relations);
    truth.num_relations = CheckRelations(path, config);
    truth.relations = ReadTextFile(path);
  }
  return truth;
}

}  // namespace nightmap
