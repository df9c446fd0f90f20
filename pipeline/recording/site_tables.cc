// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/site_tables.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/options.h"

namespace nightmap {
namespace {

const Range kSize_px{1, 32768};
const Range kFocal_px{1, 1e6};
const Range kCenter_px{-1e6, 1e6};
const Range kDistortion{-100, 100};

// A [[camera]] table as written.
struct CameraTable {
  RgbdCamera camera;
  OPTION_AT("id", camera.camera_id, "name that sequences refer to");
  OPTION_AT("width", camera.color.width, kSize_px, "columns of the color image, px");
  OPTION_AT("height", camera.color.height, kSize_px, "rows of the color image, px");
  OPTION_AT("fx", camera.color.fx, kFocal_px, "focal length, px");
  OPTION_AT("fy", camera.color.fy, kFocal_px, "focal length, px");
  OPTION_AT("cx", camera.color.cx, kCenter_px, "principal point, px");
  OPTION_AT("cy", camera.color.cy, kCenter_px, "principal point, px");
  OPTION_AT("k1", camera.color.k1, kDistortion, "radial distortion");
  OPTION_AT("k2", camera.color.k2, kDistortion, "radial distortion");
  OPTION_AT("p1", camera.color.p1, kDistortion, "tangential distortion");
  OPTION_AT("p2", camera.color.p2, kDistortion, "tangential distortion");
  OPTION_AT("k3", camera.color.k3, kDistortion, "radial distortion");
  OPTION(double, working_mpx, kWorking_mpx, {0.01, 1000}, "million pixels to reduce pictures to");
  OPTION_AT("k4", camera.color.k4, kDistortion, "of a fisheye, or of OpenCV's rational model");
  OPTION_AT("k5", camera.color.k5, kDistortion, "of OpenCV's rational model");
  OPTION_AT("k6", camera.color.k6, kDistortion, "of OpenCV's rational model");
  OPTION(std::string, lens, "pinhole", {"pinhole", "fisheye"}, "OpenCV's model of the lens");
  OPTION_AT("picture_bits", camera.picture_bits, {9, 16}, "bits that 16-bit pictures use");
  OPTION(std::vector<double>, robot_from_camera, {}, {-1000, 1000}, "tx ty tz (m) qx qy qz qw");
  OPTION(std::string, mask, "", "picture, white where the robot is; relative to root");
  OPTION_AT("depth_units_per_m", camera.depth_units_per_m, {1, 1e6}, "raw units per metre");
  OPTION_AT("depth_along_ray", camera.depth_along_ray,
            "depth is the distance from the camera, as simulators give it, and not z");
  OPTION_AT("depth_offset_m", camera.depth_offset_m, {-10, 10},
            "what the sensor measures too far at any distance");
  OPTION_AT("min_depth_m", camera.min_depth_m, {0, 1000}, "nearer depth is ignored");
  OPTION_AT("max_depth_m", camera.max_depth_m, {0.01, 1000},
            "farther depth makes no part of the map");
  OPTION_AT("min_confidence", camera.min_confidence, {1, 255}, "less sure depth is ignored");
  OPTION_AT("depth_noise_constant_m", camera.noise.constant_m, {DepthNoise::kMinConstant_m, 1},
            "depth sigma at 0 m");
  OPTION_AT("depth_noise_quadratic_per_m", camera.noise.quadratic_per_m, {0, 1},
            "growth of the depth sigma with depth squared");
  OPTION_AT("depth_registered", camera.depth_registered, "depth pixels are color pixels");
  OPTION_AT("depth_width", camera.depth.width, kSize_px, "columns of the depth image, px");
  OPTION_AT("depth_height", camera.depth.height, kSize_px, "rows of the depth image, px");
  OPTION_AT("depth_fx", camera.depth.fx, kFocal_px, "focal length, px");
  OPTION_AT("depth_fy", camera.depth.fy, kFocal_px, "focal length, px");
  OPTION_AT("depth_cx", camera.depth.cx, kCenter_px, "principal point, px");
  OPTION_AT("depth_cy", camera.depth.cy, kCenter_px, "principal point, px");
  OPTION(std::vector<double>, color_from_depth, {}, {-1000, 1000}, "tx ty tz (m) qx qy qz qw");
  REGISTER_OPTIONS();
};

}  // namespace

std::string Where(const toml::node& node, const std::string& source) {
  if (source == kQuerySource) return source;
  return fmt::format("{}:{}", source, node.source().begin.line);
}

void CheckPath(const std::string& text, const char* key, const std::string& where) {
  const auto path = std::filesystem::path(text).lexically_normal();
  if (path.is_absolute() || (!path.empty() && *path.begin() == "..")) {
    throw UsageError(
        "{}: {} = \"{}\" must lie inside the data folder: give a relative path", where, key, text);
  }
}

void Require(const toml::table& table, const Names& names, const std::string& where) {
  for (const std::string& name : names) {
    if (!table.contains(name)) throw UsageError("{}: '{}' is missing: add it", where, name);
  }
}

void Refuse(const toml::table& table,
            const Names& names,
            const std::string& where,
            const std::string& why) {
  for (const std::string& name : names) {
    if (table.contains(name)) throw UsageError("{}: '{}' {}: remove it", where, name, why);
  }
}

Rigid3 ToPose(const std::vector<double>& v, const char* key, const std::string& where) {
  if (v.size() != 7) {
    throw UsageError("{}: {} has {} numbers: give tx ty tz qx qy qz qw", where, key, v.size());
  }
  Rigid3 pose{Eigen::Quaterniond(v[6], v[3], v[4], v[5]), {v[0], v[1], v[2]}};
  if (!(std::abs(pose.rotation.norm() - 1) < 1e-2)) {
    throw UsageError("{}: the quaternion in {} has length {:.3g}: give a unit one",
                     where,
                     key,
                     pose.rotation.norm());
  }
  pose.rotation.normalize();
  return pose;
}

// A comma in the wrong place otherwise costs a night. A cropped picture's axis may pass beside it.
void CheckCenter(const char* key,
                 double center_px,
                 const char* size_key,
                 int size_px,
                 const std::string& where) {
  if (center_px > -size_px && center_px < 2 * size_px) return;
  throw UsageError("{}: {} = {} is far outside the picture, whose {} is {}",
                   where,
                   key,
                   center_px,
                   size_key,
                   size_px);
}

// The fisheye's k1 k2 k3 k4 without its `lens` would be taken for another model's.
void CheckCoefficients(const toml::table& table, Lens lens, const std::string& where) {
  if (lens == Lens::kFisheye) {
    Require(table, {"k1", "k2", "k3", "k4"}, where);
    return Refuse(table, {"p1", "p2", "k5", "k6"}, where, "is not of lens = \"fisheye\"");
  }
  const auto has = [&](const std::string& name) { return table.contains(name); };
  const Names eight = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  const bool is_rational = has("k4") || has("k5") || has("k6");
  if (!is_rational || std::ranges::all_of(eight, has)) return;
  throw UsageError(
      "{}: k4 k5 k6 belong to OpenCV's eight, k1 k2 p1 p2 k3 k4 k5 k6: give all of them, or lens = "
      "\"fisheye\" with k1 k2 k3 k4",
      where);
}

// Coefficients in another order, or of another model, fold the picture.
void CheckDistortion(const Camera& camera, const std::string& where) {
  constexpr double kMaxShift = 0.5;
  const double shift = LargestDistortion(camera);
  if (shift <= kMaxShift) return;
  throw UsageError(
      "{}: {} {}: they must be OpenCV's, in this order{}",
      where,
      camera.lens == Lens::kFisheye ? "k1 k2 k3 k4 of the fisheye"
      : camera.IsRational()         ? "k1 k2 p1 p2 k3 k4 k5 k6"
                                    : "k1 k2 p1 p2 k3",
      std::isinf(shift)
          ? "fold the picture"
          : fmt::format("move its border by {:.0f} % of half its diagonal", 100 * shift),
      camera.lens == Lens::kFisheye ? "" : " (k3 is the fifth, not the third)");
}

void AddCamera(const toml::table& table, const std::string& source, SiteConfig* site) {
  const std::string where = Where(table, source);
  const Names depth_keys = {"depth_width",
                            "depth_height",
                            "depth_fx",
                            "depth_fy",
                            "depth_cx",
                            "depth_cy",
                            "color_from_depth"};
  CameraTable parsed;
  RegisterOptions(parsed).ParseTable(table, source);
  Require(table, {"id", "width", "height", "fx", "fy", "cx", "cy"}, where);
  RgbdCamera& camera = parsed.camera;
  if (!table.contains("depth_units_per_m")) camera.depth_units_per_m = 0;
  CheckCenter("cx", camera.color.cx, "width", camera.color.width, where);
  CheckCenter("cy", camera.color.cy, "height", camera.color.height, where);
  if (parsed.lens == "fisheye") camera.color.lens = Lens::kFisheye;
  CheckCoefficients(table, camera.color.lens, where);
  CheckDistortion(camera.color, where);
  if (camera.min_depth_m >= camera.max_depth_m) {
    throw UsageError("{}: min_depth_m = {} must be below max_depth_m = {}",
                     where,
                     camera.min_depth_m,
                     camera.max_depth_m);
  }
  if (camera.depth_registered) {
    Refuse(table, depth_keys, where, "needs depth_registered = false");
  } else {
    Require(table, depth_keys, where);
    camera.color_from_depth = ToPose(parsed.color_from_depth, "color_from_depth", where);
  }
  if (table.contains("robot_from_camera")) {
    camera.robot_from_camera = ToPose(parsed.robot_from_camera, "robot_from_camera", where);
  }
  if (std::ranges::count(site->cameras, camera.camera_id, &RgbdCamera::camera_id) > 0) {
    throw UsageError("{}: a second camera \"{}\": rename it", where, camera.camera_id);
  }
  ReduceToWorkingSize(parsed.working_mpx, &camera);
  CheckPath(parsed.mask, "mask", where);
  if (!parsed.mask.empty()) {
    site->masks.push_back({static_cast<int>(site->cameras.size()), parsed.mask, where});
  }
  site->cameras.push_back(std::move(camera));
}

}  // namespace nightmap
