// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/map_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "stages/pose_graph/choose_floor.h"

namespace nightmap {
namespace {

Eigen::Vector3d MeanCameraUp(const std::vector<Rigid3>& graph_from_cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3& pose : graph_from_cameras) sum -= pose.rotation * Eigen::Vector3d::UnitY();
  return sum.normalized();
}

// Mean of the samples about a time; nothing when there are none.
std::optional<Eigen::Vector3d> MeanAcceleration(const std::vector<AccelerometerSample>& samples,
                                                std::int64_t time_ns) {
  constexpr std::int64_t kWindow_ns = 100'000'000;
  const auto begin =
      std::ranges::lower_bound(samples, time_ns - kWindow_ns, {}, &AccelerometerSample::time_ns);
  const auto end =
      std::ranges::upper_bound(samples, time_ns + kWindow_ns, {}, &AccelerometerSample::time_ns);
  if (begin == end) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (auto sample = begin; sample != end; ++sample) sum += sample->acceleration_m_per_s2;
  return sum / static_cast<double>(end - begin);
}

// Mean shift over normals with a shrinking window: finds the dominant horizontal surface even when
// the first guess is tilted. Nothing when too little surface faces up.
std::optional<Eigen::Vector3d> RefineUp(const std::vector<SurfacePatch>& patches,
                                        Eigen::Vector3d up,
                                        double max_tilt_rad) {
  for (double window_rad = max_tilt_rad; window_rad > 0.03; window_rad *= 0.8) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double area_m2 = 0;
    for (const SurfacePatch& patch : patches) {
      if (Angle_rad(patch.normal, up) > window_rad) continue;
      sum += patch.area_m2 * patch.normal;
      area_m2 += patch.area_m2;
    }
    if (area_m2 < 0.05) return std::nullopt;
    up = sum.normalized();
  }
  return up;
}

struct Plane {
  Eigen::Vector3d normal;
  double height_m = 0;  // normal . point on the plane
};

// Least-squares plane through the patches near a height, twice with a narrowing band.
Plane FitPlane(const std::vector<SurfacePatch>& patches,
               const Eigen::Vector3d& up,
               double height_m) {
  Plane plane{up, height_m};
  for (const double band_m : {kLevelBand_m * 1.5, kLevelBand_m}) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    double weight = 0;
    for (const SurfacePatch& patch : patches) {
      if (std::abs(plane.normal.dot(patch.point) - plane.height_m) > band_m) continue;
      mean += patch.area_m2 * patch.point;
      moment += patch.area_m2 * patch.point * patch.point.transpose();
      weight += patch.area_m2;
    }
    if (weight <= 0) return plane;
    mean /= weight;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment / weight -
                                                                mean * mean.transpose());
    Eigen::Vector3d normal = solver.eigenvectors().col(0);
    if (normal.dot(up) < 0) normal = -normal;
    if (Angle_rad(normal, up) > 0.1) return plane;  // a strip does not determine a plane
    plane = {normal, normal.dot(mean)};
  }
  return plane;
}

Rigid3 MapFromGraph(const Plane& floor, const Rigid3& graph_from_first_camera) {
  const Eigen::Vector3d z = floor.normal;
  Eigen::Vector3d x = graph_from_first_camera.rotation * Eigen::Vector3d::UnitZ();
  x -= z * z.dot(x);
  if (x.norm() < 0.1) x = graph_from_first_camera.rotation * Eigen::Vector3d::UnitX();
  x = (x - z * z.dot(x)).normalized();
  Eigen::Matrix3d map_from_graph;
  map_from_graph.row(0) = x;
  map_from_graph.row(1) = z.cross(x);
  map_from_graph.row(2) = z;
  const Eigen::Vector3d origin = graph_from_first_camera.translation -
                                 z * (z.dot(graph_from_first_camera.translation) - floor.height_m);
  return {Eigen::Quaterniond(map_from_graph).normalized(), -(map_from_graph * origin)};
}

}  // namespace

void MapFrameOptions::Register(OptionList& list) {
  list.Add("floor_num_keyframes",
           &floor_num_keyframes,
           Range(1, 10000),
           "keyframes whose depth is searched for the floor");
  list.Add("floor_max_depth_m", &floor_max_depth_m, Range(0.5, 20), "farther depth is not used");
  list.Add("floor_max_tilt_rad",
           &floor_max_tilt_rad,
           Range(0.05, 1.5),
           "how far the first guess of up may be off");
  list.Add("floor_min_area_m2",
           &floor_min_area_m2,
           Range(0.01, 100),
           "a smaller level surface is never taken as floor");
  list.Add("floor_min_camera_height_m",
           &floor_min_camera_height_m,
           Range(0, 5),
           "cameras are at least this far above the floor");
}

Eigen::Vector3d UpFromAccelerometer(const std::vector<AccelerometerSample>& samples,
                                    const std::vector<StampedPose>& keyframes) {
  constexpr double kMinMean_m_per_s2 = 5;  // half of gravity
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const StampedPose& keyframe : keyframes) {
    const auto mean = MeanAcceleration(samples, keyframe.time_ns);
    if (!mean) continue;
    sum += keyframe.pose.rotation * *mean;
    ++count;
  }
  if (count == 0) {
    throw DataError(
        "acceleration: no sample within 0.1 s of a keyframe; correct its times or leave its "
        "[[signal]] out of the site config");
  }
  if (!(sum.norm() / count >= kMinMean_m_per_s2)) {
    throw DataError(
        "acceleration: the mean over {} keyframes is {:.2f} m/s2, not gravity's 9.8; correct "
        "robot_from_sensor and robot_from_camera, or leave its [[signal]] out of the site config",
        count,
        sum.norm() / count);
  }
  return sum.normalized();
}

MapFrame FindMapFrame(const MapFrameOptions& options,
                      const std::vector<SurfacePatch>& patches,
                      const std::vector<Rigid3>& graph_from_cameras,
                      const std::optional<Eigen::Vector3d>& up_in_graph) {
  MapFrame frame;
  const Eigen::Vector3d guess = up_in_graph ? *up_in_graph : MeanCameraUp(graph_from_cameras);
  frame.gravity_source = up_in_graph ? "accelerometer" : "camera attitude";
  Eigen::Vector3d up = guess;
  if (const auto refined =
          RefineUp(patches, guess, up_in_graph ? 0.15 : options.floor_max_tilt_rad)) {
    up = *refined;
    if (!up_in_graph) frame.gravity_source = "horizontal surfaces";
  }
  const FloorChoice choice = ChooseFloor(options, patches, graph_from_cameras, up);
  Plane floor{up, choice.surface.height_m};
  if (!choice.surface.cells.empty()) {
    floor = FitPlane(FacingUp(patches, up), up, choice.surface.height_m);
  }
  frame.floor_source = choice.source;
  frame.floor_area_m2 = choice.surface.Area_m2();
  frame.floor_num_keyframes = choice.surface.num_keyframes;
  frame.below_floor_share = choice.below_share;
  frame.map_from_graph = MapFromGraph(floor, graph_from_cameras.front());
  frame.camera_height_m = MedianHeight_m(graph_from_cameras, floor.normal) - floor.height_m;
  return frame;
}

}  // namespace nightmap
