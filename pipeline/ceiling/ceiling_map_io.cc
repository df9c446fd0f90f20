// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_map_io.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kCeilingMapFormat[] = "nightmap ceiling map";
constexpr int kCeilingMapVersion = 1;
constexpr char kCeilingMapUnits[] =
    "poses: x y (m) heading (rad) in the map; landmark_position_m, landmark_covariance_m2: m in "
    "the map; landmark_last_raw_px: px in the image file";
constexpr std::uint8_t kWithoutOdometry = 1;
constexpr std::uint8_t kSlipped = 2;

// One column list per quantity, written row after row.
template <typename T, typename Row>
void Append(const Row& row, Array<T>* array) {
  array->cols = static_cast<std::size_t>(row.size());
  array->values.insert(array->values.end(), row.data(), row.data() + row.size());
  ++array->rows;
}

Eigen::Vector3d Vector(const Rigid2& pose) {
  return {pose.translation.x(), pose.translation.y(), pose.heading_rad};
}

void WriteFrames(const std::vector<CeilingFrame>& frames, Hdf5Writer* file) {
  std::vector<std::int64_t> time_ns;
  Array<double> pose{0, 3, {}}, covariance{0, 9, {}};
  std::vector<double> nis;
  std::vector<std::int32_t> num_residuals, num_misfits;
  std::vector<std::uint8_t> flags;
  for (const CeilingFrame& frame : frames) {
    time_ns.push_back(frame.time_ns);
    Append(Vector(frame.map_from_robot_then), &pose);
    Append(frame.covariance, &covariance);
    nis.push_back(frame.nis);
    num_residuals.push_back(frame.num_residuals);
    num_misfits.push_back(frame.num_misfits);
    flags.push_back(static_cast<std::uint8_t>((frame.has_odometry ? 0 : kWithoutOdometry) |
                                              (frame.has_slipped ? kSlipped : 0)));
  }
  file->WriteList("frame_time_ns", time_ns);
  file->Write("frame_pose", pose);
  file->Write("frame_covariance", covariance);
  file->WriteList("frame_nis", nis);
  file->WriteList("frame_num_residuals", num_residuals);
  file->WriteList("frame_num_misfits", num_misfits);
  file->WriteList("frame_flags", flags);
}

void WriteLandmarks(const std::vector<CeilingLandmark>& landmarks, Hdf5Writer* file) {
  std::vector<std::int64_t> track_id, last_time_ns;
  std::vector<std::int32_t> anchor, num_sightings;
  Array<double> position{0, 3, {}}, covariance{0, 9, {}};
  Array<float> last_raw_px{0, 2, {}};
  for (const CeilingLandmark& landmark : landmarks) {
    track_id.push_back(landmark.track_id);
    anchor.push_back(landmark.anchor);
    Append(landmark.position_m, &position);
    Append(landmark.covariance_m2, &covariance);
    num_sightings.push_back(landmark.num_sightings);
    last_time_ns.push_back(landmark.last_time_ns);
    Append(landmark.last_raw_px, &last_raw_px);
  }
  file->WriteList("landmark_track_id", track_id);
  file->WriteList("landmark_anchor", anchor);
  file->Write("landmark_position_m", position);
  file->Write("landmark_covariance_m2", covariance);
  file->WriteList("landmark_num_sightings", num_sightings);
  file->WriteList("landmark_last_time_ns", last_time_ns);
  file->Write("landmark_last_raw_px", last_raw_px);
}

}  // namespace

void WriteCeilingMap(const std::filesystem::path& path,
                     const CeilingMap& map,
                     const std::string& config) {
  Hdf5Writer file(path, kCeilingMapFormat, kCeilingMapVersion, config, kCeilingMapUnits);
  WriteFrames(map.frames, &file);
  Array<double> pose{0, 3, {}}, covariance{0, 9, {}};
  for (const CeilingAnchor& anchor : map.anchors) {
    Append(Vector(anchor.map_from_anchor), &pose);
    Append(anchor.covariance, &covariance);
  }
  file.Write("anchor_pose", pose);
  file.Write("anchor_covariance", covariance);
  WriteLandmarks(map.landmarks, &file);
  Array<std::int32_t> ends{0, 2, {}};
  std::vector<std::int32_t> num_landmarks;
  for (const CeilingLoop& loop : map.loops) {
    ends.values.insert(ends.values.end(), {loop.now, loop.then});
    ++ends.rows;
    num_landmarks.push_back(loop.num_landmarks);
  }
  file.Write("loop_anchors", ends);
  file.WriteList("loop_num_landmarks", num_landmarks);
  file.Close();
}

std::string LandmarksToPly(const std::vector<CeilingLandmark>& landmarks) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\ncomment map frame: the robot's at its start, z up, metres\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float sigma_m\n"
      "end_header\n",
      landmarks.size());
  double lowest = 0, highest = 0;
  if (!landmarks.empty()) {
    const auto height = [](const CeilingLandmark& landmark) { return landmark.position_m.z(); };
    const auto [low, high] = std::ranges::minmax(landmarks, {}, height);
    lowest = low.position_m.z();
    highest = high.position_m.z();
  }
  const double range_m = std::max(highest - lowest, 1e-3);
  for (const CeilingLandmark& landmark : landmarks) {
    const Eigen::Vector3d& p = landmark.position_m;
    const auto shade = static_cast<int>(std::lround(255 * (p.z() - lowest) / range_m));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(landmark.covariance_m2);
    text += fmt::format("{:.4f} {:.4f} {:.4f} {} {} {} {:.4f}\n",
                        p.x(),
                        p.y(),
                        p.z(),
                        shade,
                        96,
                        255 - shade,
                        std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff())));
  }
  return text;
}

}  // namespace nightmap
