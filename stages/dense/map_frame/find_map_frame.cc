// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/find_map_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "stages/dense/map_frame/choose_floor.h"
#include "stages/dense/map_frame/choose_up.h"
#include "stages/dense/map_frame/up_candidates.h"

namespace nightmap {
namespace {

constexpr double kUpWindow_rad = 0.15;  // what alignments and accelerometers are within

// The mean in the given frame of a direction that each of the poses sees alike.
Eigen::Vector3d MeanDirection(const std::vector<Rigid3>& given_from_sources,
                              const Eigen::Vector3d& in_source) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3& pose : given_from_sources) sum += pose.rotation * in_source;
  return sum.normalized();
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

Rigid3 MapFromGiven(const Plane& floor, const Rigid3& given_from_first_camera) {
  const Eigen::Vector3d z = floor.normal;
  Eigen::Vector3d x = given_from_first_camera.rotation * Eigen::Vector3d::UnitZ();
  x -= z * z.dot(x);
  if (x.norm() < 0.1) x = given_from_first_camera.rotation * Eigen::Vector3d::UnitX();
  x = (x - z * z.dot(x)).normalized();
  Eigen::Matrix3d map_from_given;
  map_from_given.row(0) = x;
  map_from_given.row(1) = z.cross(x);
  map_from_given.row(2) = z;
  const Eigen::Vector3d origin = given_from_first_camera.translation -
                                 z * (z.dot(given_from_first_camera.translation) - floor.height_m);
  return {Eigen::Quaterniond(map_from_given).normalized(), -(map_from_given * origin)};
}

// Up by the pictures, of which the frame gets a description.
Eigen::Vector3d UpFromPictures(const MapFrameOptions& options,
                               const std::vector<SurfacePatch>& patches,
                               const std::vector<Rigid3>& given_from_cameras,
                               const UpInput& input,
                               MapFrame* frame) {
  frame->gravity_source = "camera attitude";
  const Eigen::Vector3d attitude =
      input.is_mount_stated ? MeanDirection(input.given_from_robots, Eigen::Vector3d::UnitZ())
                            : MeanDirection(given_from_cameras, -Eigen::Vector3d::UnitY());
  if (patches.empty()) return attitude;
  const auto level = RefineUp(patches, attitude, options.floor_max_tilt_rad);
  const UpChoice choice = ChooseUp(patches,
                                   given_from_cameras,
                                   input.given_from_robots,
                                   input.is_mount_stated,
                                   level ? *level : AlignToSurfaces(patches, attitude));
  if (level) frame->gravity_source = "horizontal surfaces";
  if (!choice.is_first) frame->gravity_source = "surfaces and motion";
  frame->up_odds = choice.odds;
  frame->up_direction = choice.direction;
  frame->next_up_direction = choice.next_direction;
  if (choice.is_first) return choice.up;
  return RefineUp(patches, choice.up, kUpWindow_rad).value_or(choice.up);
}

Eigen::Vector3d FindUp(const MapFrameOptions& options,
                       const std::vector<SurfacePatch>& patches,
                       const std::vector<Rigid3>& given_from_cameras,
                       const UpInput& input,
                       MapFrame* frame) {
  if (!input.measured_in_given) {
    return UpFromPictures(options, patches, given_from_cameras, input, frame);
  }
  frame->gravity_source = "accelerometer";
  return RefineUp(patches, *input.measured_in_given, kUpWindow_rad)
      .value_or(*input.measured_in_given);
}

}  // namespace

MapFrame FindMapFrame(const MapFrameOptions& options,
                      const std::vector<SurfacePatch>& patches,
                      const std::vector<Rigid3>& given_from_cameras,
                      const UpInput& input) {
  MapFrame frame;
  const Eigen::Vector3d up = FindUp(options, patches, given_from_cameras, input, &frame);
  const FloorChoice choice = ChooseFloor(options, patches, given_from_cameras, up);
  Plane floor{up, choice.surface.height_m};
  if (!choice.surface.cells.empty()) {
    floor = FitPlane(FacingUp(patches, up), up, choice.surface.height_m);
  }
  frame.floor_source = choice.source;
  frame.floor_area_m2 = choice.surface.Area_m2();
  frame.floor_num_keyframes = choice.surface.num_keyframes;
  frame.below_floor_share = choice.below_share;
  frame.map_from_given = MapFromGiven(floor, given_from_cameras.front());
  frame.camera_height_m = MedianHeight_m(given_from_cameras, floor.normal) - floor.height_m;
  return frame;
}

}  // namespace nightmap
