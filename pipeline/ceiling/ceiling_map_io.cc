// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_map_io.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kCeilingMapFormat[] = "nightmap ceiling map";
constexpr int kCeilingMapVersion = 2;
constexpr char kCeilingMapUnits[] =
    "poses: x y (m) heading (rad) in the map; landmark_position_m, landmark_covariance_m2: m in "
    "the map; landmark_last_raw_px: px in the image file";
constexpr std::uint8_t kWithoutOdometry = 1;
constexpr std::uint8_t kSlipped = 2;

// A frame, and its flags in the file.
struct StoredFrame : CeilingFrame {
  StoredFrame() = default;
  StoredFrame(const CeilingFrame& frame)
      : CeilingFrame(frame),
        flags(static_cast<std::uint8_t>((frame.has_odometry ? 0 : kWithoutOdometry) |
                                        (frame.has_slipped ? kSlipped : 0))) {}
  std::uint8_t flags = 0;
};

// As x y (m) heading (rad).
template <typename Member>
constexpr auto PoseColumn(const char* name, Member pose) {
  return Hdf5Column(
      name, MemberOf(pose, &Rigid2::translation), MemberOf(pose, &Rigid2::heading_rad));
}

constexpr auto kCeilingFrames =
    Hdf5Table<StoredFrame>(Hdf5Column("frame_time_ns", &StoredFrame::time_ns)
                               .Pairs(Ascending(&StoredFrame::time_ns), "does not ascend"),
                           PoseColumn("frame_pose", &StoredFrame::map_from_robot_then),
                           Hdf5Column("frame_covariance", &StoredFrame::covariance),
                           Hdf5Column("frame_nis", &StoredFrame::nis),
                           Hdf5Column("frame_num_residuals", &StoredFrame::num_residuals),
                           Hdf5Column("frame_num_misfits", &StoredFrame::num_misfits),
                           Hdf5Column("frame_flags", &StoredFrame::flags));

constexpr auto kAnchors =
    Hdf5Table<CeilingAnchor>(PoseColumn("anchor_pose", &CeilingAnchor::map_from_anchor),
                             Hdf5Column("anchor_covariance", &CeilingAnchor::covariance));

constexpr auto kLandmarks = Hdf5Table<CeilingLandmark>(
    Hdf5Column("landmark_track_id", &CeilingLandmark::track_id),
    Hdf5Column("landmark_anchor", &CeilingLandmark::anchor),
    Hdf5Column("landmark_position_m", &CeilingLandmark::position_m),
    Hdf5Column("landmark_covariance_m2", &CeilingLandmark::covariance_m2),
    Hdf5Column("landmark_num_sightings", &CeilingLandmark::num_sightings),
    Hdf5Column("landmark_last_time_ns", &CeilingLandmark::last_time_ns),
    Hdf5Column("landmark_last_raw_px", &CeilingLandmark::last_raw_px));

constexpr auto kLoops =
    Hdf5Table<CeilingLoop>(Hdf5Column("loop_anchors", &CeilingLoop::now, &CeilingLoop::then),
                           Hdf5Column("loop_num_landmarks", &CeilingLoop::num_landmarks));

constexpr auto kMetAgain = Hdf5Table<MetAgain>(
    Hdf5Column("met_again_track_id", &MetAgain::track_id, &MetAgain::landmark_track_id));

constexpr auto kMounting =
    Hdf5Table<decltype(CeilingMap::mounting)>(Hdf5Column("mounting", kItself));

std::vector<CeilingFrame> ReadMapFrames(const Hdf5Reader& file) {
  std::vector<CeilingFrame> frames;
  for (StoredFrame& frame : kCeilingFrames.Read(file)) {
    frame.map_from_robot = frame.map_from_robot_then;
    frame.has_odometry = (frame.flags & kWithoutOdometry) == 0;
    frame.has_slipped = (frame.flags & kSlipped) != 0;
    frames.push_back(frame);
  }
  return frames;
}

void CheckReferences(const Hdf5Reader& file, const CeilingMap& map) {
  const auto is_anchor = [&](int anchor) {
    return anchor >= 0 && static_cast<std::size_t>(anchor) < map.anchors.size();
  };
  std::set<std::int64_t> track_ids;
  for (const CeilingLandmark& landmark : map.landmarks) {
    file.Demand(is_anchor(landmark.anchor), "landmark_anchor");
    file.Demand(
        track_ids.insert(landmark.track_id).second, "landmark_track_id", "has a landmark twice");
  }
  for (const CeilingLoop& loop : map.loops) {
    file.Demand(is_anchor(loop.now) && is_anchor(loop.then), "loop_anchors");
  }
  for (const MetAgain& met : map.met_again) {
    file.Demand(track_ids.contains(met.landmark_track_id),
                "met_again_track_id",
                "names a landmark that is not there");
  }
}

}  // namespace

void WriteCeilingMap(const std::filesystem::path& path,
                     const CeilingMap& map,
                     const std::string& config) {
  Hdf5Writer file(path, kCeilingMapFormat, kCeilingMapVersion, config, kCeilingMapUnits);
  kCeilingFrames.Write(map.frames, &file);
  kAnchors.Write(map.anchors, &file);
  kLandmarks.Write(map.landmarks, &file);
  kLoops.Write(map.loops, &file);
  kMetAgain.Write(map.met_again, &file);
  kMounting.Write(std::array{map.mounting}, &file);
  file.Close();
}

CeilingMap ReadCeilingMap(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kCeilingMapFormat, kCeilingMapVersion);
  CeilingMap map;
  map.frames = ReadMapFrames(file);
  map.anchors = kAnchors.Read(file);
  map.landmarks = kLandmarks.Read(file);
  map.loops = kLoops.Read(file);
  map.met_again = kMetAgain.Read(file);
  CheckReferences(file, map);
  const auto mounting = kMounting.Read(file);
  file.Demand(mounting.size() == 1, "mounting");
  map.mounting = mounting[0];
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
