// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/map_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr double kBin_m = 0.02;        // of the height histogram
constexpr double kPlaneBand_m = 0.04;  // half thickness of a plane's points

double Angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}

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

std::vector<SurfacePatch> FacingUp(const std::vector<SurfacePatch>& patches,
                                   const Eigen::Vector3d& up) {
  std::vector<SurfacePatch> chosen;
  std::ranges::copy_if(patches, std::back_inserter(chosen), [&](const SurfacePatch& patch) {
    return Angle_rad(patch.normal, up) < 0.15;
  });
  return chosen;
}

double MedianHeight_m(const std::vector<Rigid3>& graph_from_cameras, const Eigen::Vector3d& up) {
  std::vector<double> heights;
  for (const Rigid3& pose : graph_from_cameras) heights.push_back(up.dot(pose.translation));
  std::ranges::nth_element(heights,
                           heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2));
  return heights[heights.size() / 2];
}

// Area seen of the horizontal surface at a height. Overlapping views count once: by 10 cm cells.
double DistinctArea_m2(const std::vector<SurfacePatch>& patches,
                       const Eigen::Vector3d& up,
                       double height_m) {
  const Eigen::Vector3d x = up.unitOrthogonal();
  const Eigen::Vector3d y = up.cross(x);
  std::map<std::pair<int, int>, int> cells;
  for (const SurfacePatch& patch : patches) {
    if (std::abs(up.dot(patch.point) - height_m) > kPlaneBand_m) continue;
    ++cells[{static_cast<int>(std::floor(x.dot(patch.point) / 0.1)),
             static_cast<int>(std::floor(y.dot(patch.point) / 0.1))}];
  }
  return 0.01 * static_cast<double>(cells.size());
}

// Peaks of the height histogram, lowest first, that hold at least a twentieth of the largest.
std::vector<double> HorizontalHeights_m(const std::vector<SurfacePatch>& patches,
                                        const Eigen::Vector3d& up) {
  std::map<int, double> histogram;
  for (const SurfacePatch& patch : patches) {
    histogram[static_cast<int>(std::floor(up.dot(patch.point) / kBin_m))] += patch.area_m2;
  }
  const auto at = [&](int bin) {
    const auto found = histogram.find(bin);
    return found == histogram.end() ? 0.0 : found->second;
  };
  const auto smooth = [&](int bin) { return at(bin - 1) + at(bin) + at(bin + 1); };
  double largest = 0;
  for (const auto& [bin, area] : histogram) largest = std::max(largest, smooth(bin));
  std::vector<double> heights;
  for (const auto& [bin, area] : histogram) {
    const double here = smooth(bin);
    if (here >= largest / 20 && here >= smooth(bin - 1) && here > smooth(bin + 1)) {
      heights.push_back((bin + 0.5) * kBin_m);
    }
  }
  return heights;
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
  for (const double band_m : {kPlaneBand_m * 1.5, kPlaneBand_m}) {
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

// The lowest plane that is large enough and below the cameras; else the lowest one; else nothing.
struct FloorChoice {
  double height_m = 0;
  double area_m2 = 0;
  bool is_floor = false;
};

std::optional<FloorChoice> ChooseFloor(const MapFrameOptions& options,
                                       const std::vector<SurfacePatch>& horizontal,
                                       const Eigen::Vector3d& up,
                                       double camera_height_m) {
  std::optional<FloorChoice> fallback;
  for (const double height_m : HorizontalHeights_m(horizontal, up)) {
    if (camera_height_m - height_m < options.floor_min_camera_height_m) break;
    const double area_m2 = DistinctArea_m2(horizontal, up, height_m);
    if (area_m2 >= options.floor_min_area_m2) return FloorChoice{height_m, area_m2, true};
    if (!fallback || area_m2 > 2 * fallback->area_m2)
      fallback = FloorChoice{height_m, area_m2, false};
  }
  return fallback;
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
  list.Add("floor_min_area_m2", &floor_min_area_m2, Range(0.01, 100), "of a plane taken as floor");
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
        "accelerometer.csv: no sample within 0.1 s of a keyframe; correct its times or leave "
        "`accelerometer` out of the site config");
  }
  if (!(sum.norm() / count >= kMinMean_m_per_s2)) {
    throw DataError(
        "accelerometer.csv: the mean over {} keyframes is {:.2f} m/s2, not gravity's 9.8; turn it "
        "into the color camera's axes or leave `accelerometer` out of the site config",
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
  const auto horizontal = FacingUp(patches, up);
  const auto choice = ChooseFloor(options, horizontal, up, MedianHeight_m(graph_from_cameras, up));
  Plane floor{up, 0};
  if (choice) {
    floor = FitPlane(horizontal, up, choice->height_m);
    frame.floor_source = choice->is_floor ? "floor plane" : "lowest horizontal plane";
    frame.floor_area_m2 = choice->area_m2;
  } else {
    frame.floor_source = "lowest camera";
    floor.height_m = up.dot(graph_from_cameras.front().translation);
    for (const Rigid3& pose : graph_from_cameras) {
      floor.height_m = std::min(floor.height_m, up.dot(pose.translation));
    }
  }
  frame.map_from_graph = MapFromGraph(floor, graph_from_cameras.front());
  frame.camera_height_m = MedianHeight_m(graph_from_cameras, floor.normal) - floor.height_m;
  return frame;
}

}  // namespace nightmap
