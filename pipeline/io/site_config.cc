// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/site_config.h"

#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/options.h"

namespace nightmap {
namespace {

const Range kSize_px{1, 32768};
const Range kFocal_px{1, 1e6};
const Range kCenter_px{-1e6, 1e6};
const Range kDistortion{-100, 100};
const Range kFieldOfView_deg{1, 170};

// A [[camera]] table as written.
struct CameraTable {
  RgbdCamera camera;
  std::vector<double> color_from_depth;

  void Register(OptionList& list) {
    Camera& color = camera.color;
    list.Add("id", &camera.camera_id, "name that sequences refer to");
    list.Add("width", &color.width, kSize_px, "columns of the color image, px");
    list.Add("height", &color.height, kSize_px, "rows of the color image, px");
    list.Add("fx", &color.fx, kFocal_px, "focal length, px");
    list.Add("fy", &color.fy, kFocal_px, "focal length, px");
    list.Add("cx", &color.cx, kCenter_px, "principal point, px");
    list.Add("cy", &color.cy, kCenter_px, "principal point, px");
    list.Add("k1", &color.k1, kDistortion, "radial distortion");
    list.Add("k2", &color.k2, kDistortion, "radial distortion");
    list.Add("p1", &color.p1, kDistortion, "tangential distortion");
    list.Add("p2", &color.p2, kDistortion, "tangential distortion");
    list.Add("k3", &color.k3, kDistortion, "radial distortion");
    RegisterDepth(list);
  }

 private:
  void RegisterDepth(OptionList& list) {
    Camera& depth = camera.depth;
    list.Add("depth_units_per_m", &camera.depth_units_per_m, {1, 1e6}, "raw units in a metre");
    list.Add("min_depth_m", &camera.min_depth_m, {0, 1000}, "nearer depth is not used");
    list.Add("max_depth_m", &camera.max_depth_m, {0.01, 1000}, "farther depth is not used");
    list.Add("depth_noise_constant_m",
             &camera.noise.constant_m,
             {DepthNoise::kMinConstant_m, 1},
             "depth sigma at 0 m");
    list.Add("depth_noise_quadratic_per_m",
             &camera.noise.quadratic_per_m,
             {0, 1},
             "growth of the depth sigma with depth squared");
    list.Add("depth_registered", &camera.depth_registered, "depth pixels are color pixels");
    list.Add("depth_width", &depth.width, kSize_px, "columns of the depth image, px");
    list.Add("depth_height", &depth.height, kSize_px, "rows of the depth image, px");
    list.Add("depth_fx", &depth.fx, kFocal_px, "focal length, px");
    list.Add("depth_fy", &depth.fy, kFocal_px, "focal length, px");
    list.Add("depth_cx", &depth.cx, kCenter_px, "principal point, px");
    list.Add("depth_cy", &depth.cy, kCenter_px, "principal point, px");
    list.Add("color_from_depth", &color_from_depth, {-1000, 1000}, "tx ty tz (m) qx qy qz qw");
  }
};

// A [[sequence]] or [[query]] table as written.
struct SequenceTable {
  SequenceConfig sequence;
  std::string camera;

  void Register(OptionList& list) {
    SequenceConfig& s = sequence;
    list.Add("layout",
             &s.layout,
             {"tum", "seven_scenes", "video", "pictures"},
             "how the recording is laid out");
    list.Add("folder", &s.folder, "relative to root");
    list.Add("camera", &camera, "id of a [[camera]]");
    list.Add("video", &s.video, "layout video: the file, relative to folder");
    list.Add("depth_folder", &s.depth_folder, "layout video: depth images, relative to folder");
    list.Add("frame_rate_hz", &s.frame_rate_hz, {0, 1000}, "0: the video's, 30 for seven_scenes");
    list.Add("ground_truth", &s.ground_truth, "TUM trajectory, relative to root");
    list.Add("accelerometer",
             &s.accelerometer,
             "time_s ax ay az (m/s2, axes of the color camera), relative to root");
    list.Add("max_association_gap_s", &s.max_association_gap_s, {0, 10}, "color to depth image");
    list.Add("time_offset_s", &s.time_offset_s, {-2e9, 2e9}, "added to all times");
    list.Add(
        "pictures", &s.pictures, "layout pictures: folder, .txt list or file, relative to root");
    list.Add("horizontal_fov_deg",
             &s.horizontal_fov_deg,
             kFieldOfView_deg,
             "layout pictures: of those that do not say their focal length");
  }
};

std::string Where(const toml::node& node, const std::string& source) {
  return fmt::format("{}:{}", source, node.source().begin.line);
}

using Names = std::initializer_list<const char*>;

void Require(const toml::table& table, Names names, const std::string& where) {
  for (const char* name : names) {
    if (!table.contains(name)) throw UsageError("{}: '{}' is missing: add it", where, name);
  }
}

void Refuse(const toml::table& table, Names names, const std::string& where, const char* why) {
  for (const char* name : names) {
    if (table.contains(name)) throw UsageError("{}: '{}' {}: remove it", where, name, why);
  }
}

// Artifacts hold paths relative to the data folder, so nothing may lead out of it.
void CheckPath(const std::string& text, const char* key, const std::string& where) {
  const auto path = std::filesystem::path(text).lexically_normal();
  if (path.is_absolute() || (!path.empty() && *path.begin() == "..")) {
    throw UsageError(
        "{}: {} = \"{}\" must lie inside the data folder: give a relative path", where, key, text);
  }
}

Rigid3 ToPose(const std::vector<double>& v, const std::string& where) {
  if (v.size() != 7) {
    throw UsageError(
        "{}: color_from_depth has {} numbers: give tx ty tz qx qy qz qw", where, v.size());
  }
  Rigid3 pose{Eigen::Quaterniond(v[6], v[3], v[4], v[5]), {v[0], v[1], v[2]}};
  if (!(std::abs(pose.rotation.norm() - 1) < 1e-2)) {
    throw UsageError("{}: the quaternion in color_from_depth has length {:.3g}: give a unit one",
                     where,
                     pose.rotation.norm());
  }
  pose.rotation.normalize();
  return pose;
}

RgbdCamera ParseCamera(const toml::table& table, const std::string& source) {
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
  Require(table, {"id", "width", "height", "fx", "fy", "cx", "cy", "depth_units_per_m"}, where);
  RgbdCamera& camera = parsed.camera;
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
    camera.color_from_depth = ToPose(parsed.color_from_depth, where);
  }
  return camera;
}

int FindCamera(const std::vector<RgbdCamera>& cameras,
               const std::string& id,
               const std::string& where) {
  const auto found = std::ranges::find(cameras, id, &RgbdCamera::camera_id);
  if (found != cameras.end()) return static_cast<int>(found - cameras.begin());
  std::vector<std::string> ids;
  for (const RgbdCamera& camera : cameras) ids.push_back(camera.camera_id);
  throw UsageError(
      "{}: no [[camera]] has id \"{}\"; there are: {}", where, id, fmt::join(ids, ", "));
}

// The keys that a layout must have and those that do not go with it.
void CheckKeys(const toml::table& table, const std::string& layout, const std::string& where) {
  if (layout == "pictures") {
    Require(table, {"pictures"}, where);
    Refuse(table,
           {"folder", "frame_rate_hz", "max_association_gap_s", "time_offset_s", "accelerometer"},
           where,
           "does not go with layout = \"pictures\"");
    if (table.contains("camera")) {
      Refuse(table, {"horizontal_fov_deg"}, where, "is known from `camera`");
    }
  } else {
    Require(table, {"folder", "camera"}, where);
    Refuse(table, {"pictures", "horizontal_fov_deg"}, where, "needs layout = \"pictures\"");
  }
  if (layout == "video") {
    Require(table, {"video"}, where);
  } else {
    Refuse(table, {"video", "depth_folder"}, where, "needs layout = \"video\"");
  }
}

SequenceConfig ParseSequence(const toml::table& table,
                             const std::string& source,
                             const std::vector<RgbdCamera>& cameras) {
  const std::string where = Where(table, source);
  SequenceTable parsed;
  RegisterOptions(parsed).ParseTable(table, source);
  Require(table, {"layout"}, where);
  SequenceConfig& sequence = parsed.sequence;
  CheckKeys(table, sequence.layout, where);
  sequence.camera_idx =
      table.contains("camera") ? FindCamera(cameras, parsed.camera, where) : kOwnCameras;
  sequence.source = where;
  CheckPath(sequence.folder, "folder", where);
  CheckPath(sequence.video, "video", where);
  CheckPath(sequence.depth_folder, "depth_folder", where);
  CheckPath(sequence.ground_truth, "ground_truth", where);
  CheckPath(sequence.accelerometer, "accelerometer", where);
  if (sequence.pictures.starts_with('/')) {
    throw UsageError("{}: pictures = \"{}\" must be relative to root", where, sequence.pictures);
  }
  return sequence;
}

// The tables written as [[name]].
std::vector<const toml::table*> Tables(const toml::table& root,
                                       const char* name,
                                       const std::string& source) {
  std::vector<const toml::table*> tables;
  const toml::node* node = root.get(name);
  if (!node) return tables;
  if (!node->is_array_of_tables()) {
    throw UsageError("{}: '{}' must be written as [[{}]]", Where(*node, source), name, name);
  }
  for (const toml::node& table : *node->as_array()) tables.push_back(table.as_table());
  return tables;
}

void CheckTopLevel(const SiteConfig& site, const std::string& source) {
  CheckPath(site.root, "root", source);
  if (site.hold_out_every == 1) {
    throw UsageError("{}: hold_out_every = 1 would leave nothing to map: give 0 or at least 2",
                     source);
  }
  if (site.cameras.empty()) throw UsageError("{}: add a [[camera]]", source);
  if (site.sequences.empty()) throw UsageError("{}: add a [[sequence]]", source);
}

}  // namespace

SiteConfig ParseSiteConfig(std::string_view text, const std::string& source) {
  toml::table root;
  try {
    root = toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    throw UsageError(
        "{}:{}: not valid TOML: {}", source, error.source().begin.line, error.description());
  }
  SiteConfig site;
  for (const toml::table* table : Tables(root, "camera", source)) {
    RgbdCamera camera = ParseCamera(*table, source);
    if (std::ranges::count(site.cameras, camera.camera_id, &RgbdCamera::camera_id) > 0) {
      throw UsageError(
          "{}: a second camera \"{}\": rename it", Where(*table, source), camera.camera_id);
    }
    site.cameras.push_back(std::move(camera));
  }
  for (const toml::table* table : Tables(root, "sequence", source)) {
    site.sequences.push_back(ParseSequence(*table, source, site.cameras));
    if (site.sequences.back().layout != "pictures") continue;
    throw UsageError("{}: layout = \"pictures\" has no depth to map: make it a [[query]]",
                     site.sequences.back().source);
  }
  for (const toml::table* table : Tables(root, "query", source)) {
    site.queries.push_back(ParseSequence(*table, source, site.cameras));
  }
  for (const char* name : {"camera", "sequence", "query"}) root.erase(name);
  OptionList list;
  list.Add("root", &site.root, "folder of the site, relative to the data folder");
  list.Add("hold_out_every", &site.hold_out_every, {0, 1e6}, "every Nth frame becomes a query");
  list.ParseTable(root, source);
  CheckTopLevel(site, source);
  return site;
}

SiteConfig ReadSiteConfig(const std::filesystem::path& path) {
  return ParseSiteConfig(ReadFile(path), path.string());
}

}  // namespace nightmap
