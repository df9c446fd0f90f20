// SPDX-License-Identifier: Apache-2.0
// cameras.json, for frames_io.h.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/json_fields.h"
#include "pipeline/io/masks_io.h"

namespace nightmap {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCamerasFormat = "nightmap cameras";
// 2: focal_sigma_ratio, 3: mask_runs, depth_along_ray, 4: picture_bits, min_confidence,
// depth_offset_m, 5: picture_width, lenses
constexpr int kCamerasVersion = 5;
constexpr int kMaxSide_px = 32768;  // the same limit as in the site config

bool IsRationalOrFisheye(const Camera& c) { return c.IsRational() || c.lens == Lens::kFisheye; }

Json ToJson(const Camera& c) {
  Json json = {{"width", c.width},
               {"height", c.height},
               {"fx", c.fx},
               {"fy", c.fy},
               {"cx", c.cx},
               {"cy", c.cy},
               {"k1", c.k1},
               {"k2", c.k2},
               {"p1", c.p1},
               {"p2", c.p2},
               {"k3", c.k3}};
  if (IsRationalOrFisheye(c)) {
    json.update({{"k4", c.k4}, {"k5", c.k5}, {"k6", c.k6}});
    json["lens"] = c.lens == Lens::kFisheye ? "fisheye" : "pinhole";
  }
  return json;
}

Json ToJson(const Rigid3& pose) {
  const auto& t = pose.translation;
  const auto& q = pose.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

bool IsIdentity(const Rigid3& pose) {
  return pose.translation.isZero(0) && pose.rotation.coeffs() == Rigid3{}.rotation.coeffs();
}

Json ToJson(const RgbdCamera& camera) {
  Json json = {{"camera_id", camera.camera_id},
               {"color", ToJson(camera.color)},
               {"depth_registered", camera.depth_registered},
               {"depth_units_per_m", camera.depth_units_per_m},
               {"min_depth_m", camera.min_depth_m},
               {"max_depth_m", camera.max_depth_m},
               {"depth_noise_constant_m", camera.noise.constant_m},
               {"depth_noise_quadratic_per_m", camera.noise.quadratic_per_m}};
  if (!camera.depth_registered) {
    json["depth"] = ToJson(camera.depth);
    json["color_from_depth"] = ToJson(camera.color_from_depth);
  }
  if (!IsIdentity(camera.robot_from_camera)) {
    json["robot_from_camera"] = ToJson(camera.robot_from_camera);
  }
  if (camera.min_confidence > 0) json["min_confidence"] = camera.min_confidence;
  if (camera.picture_width > 0) {
    json["picture_width"] = camera.picture_width;
    json["picture_height"] = camera.picture_height;
  }
  if (camera.picture_bits < 16) json["picture_bits"] = camera.picture_bits;
  if (camera.depth_along_ray) json["depth_along_ray"] = true;
  if (camera.depth_offset_m != 0) json["depth_offset_m"] = camera.depth_offset_m;
  if (!camera.IsCalibrated()) json["focal_sigma_ratio"] = camera.focal_sigma_ratio;
  if (camera.mask) json["mask_runs"] = PackMask(0, *camera.mask).runs;
  return json;
}

double AtLeast(const Json& json, const char* name, double min) {
  const double value = FiniteAt(json, name);
  if (value >= min) return value;
  throw DataError("{} is {}, must be at least {}: correct it in the site config and run make",
                  name,
                  value,
                  min);
}

double PositiveAt(const Json& json, const char* name) {
  const double value = FiniteAt(json, name);
  if (!(value > 0)) throw DataError("{} is {}, must be positive", name, value);
  return value;
}

Camera CameraFromJson(const Json& json) {
  Camera camera;
  camera.width = IntegerAt(json, "width", 1, kMaxSide_px);
  camera.height = IntegerAt(json, "height", 1, kMaxSide_px);
  camera.fx = PositiveAt(json, "fx");
  camera.fy = PositiveAt(json, "fy");
  camera.cx = FiniteAt(json, "cx");
  camera.cy = FiniteAt(json, "cy");
  camera.k1 = FiniteAt(json, "k1");
  camera.k2 = FiniteAt(json, "k2");
  camera.p1 = FiniteAt(json, "p1");
  camera.p2 = FiniteAt(json, "p2");
  camera.k3 = FiniteAt(json, "k3");
  if (!json.contains("lens")) return camera;
  camera.k4 = FiniteAt(json, "k4");
  camera.k5 = FiniteAt(json, "k5");
  camera.k6 = FiniteAt(json, "k6");
  const auto lens = json.at("lens").get<std::string>();
  if (lens != "pinhole" && lens != "fisheye") throw DataError("lens is '{}', which is none", lens);
  camera.lens = lens == "fisheye" ? Lens::kFisheye : Lens::kPinhole;
  return camera;
}

Rigid3 PoseAt(const Json& json, const char* name) {
  const auto v = json.at(name).get<std::vector<double>>();
  if (v.size() != 7) throw DataError("{} has {} numbers, not 7", name, v.size());
  Rigid3 pose{Eigen::Quaterniond(v[6], v[3], v[4], v[5]), {v[0], v[1], v[2]}};
  if (!(std::abs(pose.rotation.norm() - 1) < 1e-3) || !pose.translation.allFinite()) {
    throw DataError("{} is not a rigid transform", name);
  }
  pose.rotation.normalize();
  return pose;
}

std::shared_ptr<const GrayImage> MaskAt(const Json& runs, const Camera& color) {
  PackedMask packed{0, color.width, color.height, {}};
  for (const Json& run : runs) {
    if (!run.is_number_unsigned() ||
        run.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
      throw DataError("mask_runs are not all numbers of pixels");
    }
    packed.runs.push_back(run.get<std::uint32_t>());
  }
  if (!FillsPicture(packed)) throw DataError("mask_runs do not fill the picture");
  return std::make_shared<GrayImage>(UnpackMask(packed));
}

RgbdCamera RgbdCameraFromJson(const Json& json) {
  RgbdCamera camera;
  camera.camera_id = json.at("camera_id").get<std::string>();
  camera.color = CameraFromJson(json.at("color"));
  camera.depth_registered = json.at("depth_registered").get<bool>();
  camera.depth_units_per_m = AtLeast(json, "depth_units_per_m", 0);
  if (json.contains("min_confidence")) {
    camera.min_confidence = IntegerAt(json, "min_confidence", 1, 255);
  }
  if (json.contains("picture_width")) {
    camera.picture_width = IntegerAt(json, "picture_width", camera.color.width, kMaxSide_px);
    camera.picture_height = IntegerAt(json, "picture_height", camera.color.height, kMaxSide_px);
  }
  if (json.contains("picture_bits")) camera.picture_bits = IntegerAt(json, "picture_bits", 9, 16);
  camera.depth_along_ray = json.value("depth_along_ray", false);
  if (json.contains("depth_offset_m")) camera.depth_offset_m = FiniteAt(json, "depth_offset_m");
  camera.min_depth_m = FiniteAt(json, "min_depth_m");
  camera.max_depth_m = PositiveAt(json, "max_depth_m");
  camera.noise.constant_m = AtLeast(json, "depth_noise_constant_m", DepthNoise::kMinConstant_m);
  camera.noise.quadratic_per_m = AtLeast(json, "depth_noise_quadratic_per_m", 0);
  if (!camera.depth_registered) {
    camera.depth = CameraFromJson(json.at("depth"));
    camera.color_from_depth = PoseAt(json, "color_from_depth");
  }
  if (json.contains("robot_from_camera")) {
    camera.robot_from_camera = PoseAt(json, "robot_from_camera");
  }
  if (json.contains("focal_sigma_ratio")) {
    camera.focal_sigma_ratio = PositiveAt(json, "focal_sigma_ratio");
  }
  if (json.contains("mask_runs")) camera.mask = MaskAt(json.at("mask_runs"), camera.color);
  return camera;
}

// A program must not take a guessed focal length as exact, the robot's own parts as the world,
// distances as z, bright pictures as dark, pixels of small pictures as those of large ones, unsure
// depth, or depth that is too far, as measured, nor one lens for another.
int VersionFor(const RgbdCamera& camera) {
  if (camera.picture_width > 0 || IsRationalOrFisheye(camera.color)) return 5;
  if (camera.picture_bits < 16 || camera.min_confidence > 0 || camera.depth_offset_m != 0) return 4;
  if (camera.mask || camera.depth_along_ray) return 3;
  return camera.IsCalibrated() ? 1 : 2;
}

int VersionFor(const std::vector<RgbdCamera>& cameras) {
  int version = 1;
  for (const RgbdCamera& camera : cameras) version = std::max(version, VersionFor(camera));
  return version;
}

}  // namespace

std::string CamerasToJson(const std::vector<RgbdCamera>& cameras) {
  Json json = {
      {"format", kCamerasFormat},
      {"version", VersionFor(cameras)},
      {"units", "width height fx fy cx cy: px; color_from_depth: tx ty tz (m) qx qy qz qw"},
      {"cameras", Json::array()}};
  for (const RgbdCamera& camera : cameras) json["cameras"].push_back(ToJson(camera));
  return json.dump(2) + '\n';
}

std::vector<RgbdCamera> ReadCameras(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("format").get<std::string>() != kCamerasFormat) {
      throw DataError("format is not '{}'", kCamerasFormat);
    }
    if (IntegerAt(json, "version", 1) > kCamerasVersion) {
      throw DataError("version is newer than {}: update the program", kCamerasVersion);
    }
    std::vector<RgbdCamera> cameras;
    for (const Json& camera : json.at("cameras")) cameras.push_back(RgbdCameraFromJson(camera));
    return cameras;
  } catch (const std::exception& error) {
    throw DataError("{}: {}; delete it and run make again", path.string(), JsonReason(error));
  }
}

std::vector<RgbdCamera> ReadCameras(const std::filesystem::path& path,
                                    const std::vector<FrameRecord>& frames) {
  auto cameras = ReadCameras(path);
  for (const FrameRecord& frame : frames) CheckCamera(frame, cameras, path.string());
  return cameras;
}

void CheckCamera(const FrameRecord& frame,
                 const std::vector<RgbdCamera>& cameras,
                 const std::string& list) {
  if (frame.camera_idx >= 0 && frame.camera_idx < static_cast<int>(cameras.size())) return;
  throw DataError(
      "{}: has {} cameras, but frame {} ({}) has camera_idx {}: the frames are of another run, "
      "make "
      "both again",
      list,
      cameras.size(),
      frame.frame_idx,
      frame.color.path,
      frame.camera_idx);
}

}  // namespace nightmap
