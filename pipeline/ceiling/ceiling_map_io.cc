// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_map_io.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kCeilingMapFormat[] = "nightmap ceiling map";
constexpr int kCeilingMapVersion = 2;
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

Rigid2 PoseAt(const Array<double>& array, std::size_t row) {
  return {array.values[3 * row + 2], {array.values[3 * row], array.values[3 * row + 1]}};
}

Eigen::Matrix3d MatrixAt(const Array<double>& array, std::size_t row) {
  return Eigen::Map<const Eigen::Matrix3d>(&array.values[9 * row]);
}

std::vector<CeilingFrame> ReadMapFrames(const Hdf5Reader& file) {
  const auto time_ns = file.ReadList<std::int64_t>("frame_time_ns");
  const auto pose = file.Read<double>("frame_pose", 3);
  const auto covariance = file.Read<double>("frame_covariance", 9);
  const auto nis = file.ReadList<double>("frame_nis");
  const auto num_residuals = file.ReadList<std::int32_t>("frame_num_residuals");
  const auto num_misfits = file.ReadList<std::int32_t>("frame_num_misfits");
  const auto flags = file.ReadList<std::uint8_t>("frame_flags");
  const std::size_t num = time_ns.size();
  file.Demand(pose.rows == num, "frame_pose");
  file.Demand(covariance.rows == num, "frame_covariance");
  file.Demand(nis.size() == num, "frame_nis");
  file.Demand(num_residuals.size() == num, "frame_num_residuals");
  file.Demand(num_misfits.size() == num, "frame_num_misfits");
  file.Demand(flags.size() == num, "frame_flags");
  std::vector<CeilingFrame> frames;
  for (std::size_t i = 0; i < num; ++i) {
    file.Demand(i == 0 || time_ns[i] > time_ns[i - 1], "frame_time_ns", "does not ascend");
    CeilingFrame& frame = frames.emplace_back();
    frame.time_ns = time_ns[i];
    frame.map_from_robot = frame.map_from_robot_then = PoseAt(pose, i);
    frame.covariance = MatrixAt(covariance, i);
    frame.nis = nis[i];
    frame.num_residuals = num_residuals[i];
    frame.num_misfits = num_misfits[i];
    frame.has_odometry = (flags[i] & kWithoutOdometry) == 0;
    frame.has_slipped = (flags[i] & kSlipped) != 0;
  }
  return frames;
}

std::vector<CeilingLandmark> ReadMapLandmarks(const Hdf5Reader& file, std::size_t num_anchors) {
  const auto track_id = file.ReadList<std::int64_t>("landmark_track_id");
  const auto anchor = file.ReadList<std::int32_t>("landmark_anchor");
  const auto position = file.Read<double>("landmark_position_m", 3);
  const auto covariance = file.Read<double>("landmark_covariance_m2", 9);
  const auto num_sightings = file.ReadList<std::int32_t>("landmark_num_sightings");
  const auto last_time_ns = file.ReadList<std::int64_t>("landmark_last_time_ns");
  const auto last_raw_px = file.Read<float>("landmark_last_raw_px", 2);
  const std::size_t num = track_id.size();
  file.Demand(anchor.size() == num, "landmark_anchor");
  file.Demand(position.rows == num, "landmark_position_m");
  file.Demand(covariance.rows == num, "landmark_covariance_m2");
  file.Demand(num_sightings.size() == num, "landmark_num_sightings");
  file.Demand(last_time_ns.size() == num, "landmark_last_time_ns");
  file.Demand(last_raw_px.rows == num, "landmark_last_raw_px");
  std::vector<CeilingLandmark> landmarks;
  for (std::size_t i = 0; i < num; ++i) {
    file.Demand(anchor[i] >= 0 && static_cast<std::size_t>(anchor[i]) < num_anchors,
                "landmark_anchor");
    landmarks.push_back({track_id[i],
                         anchor[i],
                         Eigen::Map<const Eigen::Vector3d>(&position.values[3 * i]),
                         MatrixAt(covariance, i),
                         num_sightings[i],
                         last_time_ns[i],
                         Eigen::Map<const Eigen::Vector2f>(&last_raw_px.values[2 * i])});
  }
  return landmarks;
}

void ReadLoops(const Hdf5Reader& file, CeilingMap* map) {
  const auto ends = file.Read<std::int32_t>("loop_anchors", 2);
  const auto num_landmarks = file.ReadList<std::int32_t>("loop_num_landmarks");
  file.Demand(num_landmarks.size() == ends.rows, "loop_num_landmarks");
  const auto is_anchor = [&](int anchor) {
    return anchor >= 0 && static_cast<std::size_t>(anchor) < map->anchors.size();
  };
  file.Demand(std::ranges::all_of(ends.values, is_anchor), "loop_anchors");
  for (std::size_t i = 0; i < ends.rows; ++i) {
    map->loops.push_back({ends.values[2 * i], ends.values[2 * i + 1], num_landmarks[i]});
  }
}

void ReadMetAgain(const Hdf5Reader& file, CeilingMap* map) {
  std::set<std::int64_t> track_ids;
  for (const CeilingLandmark& landmark : map->landmarks) {
    file.Demand(
        track_ids.insert(landmark.track_id).second, "landmark_track_id", "has a landmark twice");
  }
  const auto pairs = file.Read<std::int64_t>("met_again_track_id", 2);
  for (std::size_t i = 0; i < pairs.rows; ++i) {
    map->met_again.push_back({pairs.values[2 * i], pairs.values[2 * i + 1]});
    file.Demand(track_ids.contains(map->met_again.back().landmark_track_id),
                "met_again_track_id",
                "names a landmark that is not there");
  }
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
  Array<std::int64_t> met_again{0, 2, {}};
  for (const MetAgain& met : map.met_again) {
    met_again.values.insert(met_again.values.end(), {met.track_id, met.landmark_track_id});
    ++met_again.rows;
  }
  file.Write("met_again_track_id", met_again);
  Array<double> mounting{0, 5, {}};
  Append(map.mounting, &mounting);
  file.Write("mounting", mounting);
  file.Close();
}

CeilingMap ReadCeilingMap(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kCeilingMapFormat, kCeilingMapVersion);
  CeilingMap map;
  map.frames = ReadMapFrames(file);
  const auto pose = file.Read<double>("anchor_pose", 3);
  const auto covariance = file.Read<double>("anchor_covariance", 9);
  file.Demand(covariance.rows == pose.rows, "anchor_covariance");
  for (std::size_t i = 0; i < pose.rows; ++i) {
    map.anchors.push_back({PoseAt(pose, i), MatrixAt(covariance, i)});
  }
  map.landmarks = ReadMapLandmarks(file, map.anchors.size());
  ReadLoops(file, &map);
  ReadMetAgain(file, &map);
  const auto mounting = file.Read<double>("mounting", 5);
  file.Demand(mounting.rows == 1, "mounting");
  std::ranges::copy(mounting.values, map.mounting.data());
  return map;
}

Rigid3 MountedAs(const Rigid3& robot_from_camera, const CeilingMap& map) {
  const Eigen::Vector3d turn_rad = map.mounting.head<3>();
  Rigid3 mounted = robot_from_camera;
  mounted.translation.head<2>() += map.mounting.tail<2>();
  if (turn_rad.norm() > 0) {
    mounted.rotation = mounted.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(
                                              turn_rad.norm(), turn_rad.normalized()));
  }
  return mounted;
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
