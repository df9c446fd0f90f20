// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/objects_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_text.h"
#include "pipeline/io/yaml_map.h"
#include "pipeline/io/yaml_text.h"

namespace nightmap {
namespace {

constexpr const char* kObjectsFormat = "nightmap objects";
constexpr int kObjectsVersion = 1;
const std::set<std::string> kFileKeys = {"format", "version", "objects"};
const std::set<std::string> kObjectKeys = {
    "angle_deg", "distinctiveness", "name", "size_x_m", "size_y_m", "x_m", "y_m"};
constexpr double kMaxPosition_m = 1e8;  // up to here a double resolves micrometres
constexpr double kMaxSize_m = 1e6;
constexpr double kMaxAngle_deg = 360;
constexpr double kDegPerRad = 180 / std::numbers::pi;

double RoundedAngle_deg(double angle_rad) {
  return std::round(angle_rad * kDegPerRad * 1e9) / 1e9 + 0.0;  // + 0.0: no minus before zero
}

double ReadSize_m(const YamlMap& map, const std::string& key) {
  const double size_m = map.Number(key, -kMaxSize_m, kMaxSize_m);
  if (size_m <= 0) map.Fail(key, fmt::format("{} is {}, not above 0", key, size_m));
  return size_m;
}

MapObject ReadObject(const YamlMap& map) {
  map.CheckKeys(kObjectKeys);
  MapObject object;
  object.name = map.Text("name");
  if (object.name.empty()) map.Fail("name", "name is empty");
  if (!IsText(object.name)) {
    map.Fail("name", fmt::format("name '{}' holds control characters", AsText(object.name)));
  }
  object.map_from_object = {map.Number("angle_deg", -kMaxAngle_deg, kMaxAngle_deg) / kDegPerRad,
                            {map.Number("x_m", -kMaxPosition_m, kMaxPosition_m),
                             map.Number("y_m", -kMaxPosition_m, kMaxPosition_m)}};
  object.size_m = {ReadSize_m(map, "size_x_m"), ReadSize_m(map, "size_y_m")};
  if (map.Has("distinctiveness")) object.distinctiveness = map.Number("distinctiveness", 0, 1);
  return object;
}

void CheckHead(const YamlMap& file) {
  if (file.Text("format") != kObjectsFormat) {
    file.Fail("format", fmt::format("format is not '{}'", kObjectsFormat));
  }
  if (file.Number("version", 0, kMaxSize_m) != kObjectsVersion) {
    file.Fail(
        "version",
        fmt::format("version {}, this program reads {}", file.Text("version"), kObjectsVersion));
  }
}

}  // namespace

std::string ObjectsToYaml(const std::vector<MapObject>& objects) {
  std::string text = fmt::format("format: {}\nversion: {}\nobjects:{}\n",
                                 kObjectsFormat,
                                 kObjectsVersion,
                                 objects.empty() ? " []" : "");
  for (const MapObject& object : objects) {
    text += fmt::format(
        "  - name: {}\n    x_m: {}\n    y_m: {}\n    size_x_m: {}\n    size_y_m: {}\n"
        "    angle_deg: {}\n",
        QuotedForYaml(object.name),
        object.map_from_object.translation.x(),
        object.map_from_object.translation.y(),
        object.size_m.x(),
        object.size_m.y(),
        RoundedAngle_deg(object.map_from_object.heading_rad));
    if (object.distinctiveness) {
      text += fmt::format("    distinctiveness: {}\n", *object.distinctiveness);
    }
  }
  return text;
}

std::vector<MapObject> ReadObjects(const std::filesystem::path& path) {
  const YamlMap file(path);
  file.CheckKeys(kFileKeys);
  CheckHead(file);
  std::vector<MapObject> objects;
  std::set<std::string> names;
  for (const YamlMap& map : file.Maps("objects")) {
    objects.push_back(ReadObject(map));
    if (names.insert(objects.back().name).second) continue;
    map.Fail("name", fmt::format("name '{}' appears twice", objects.back().name));
  }
  return objects;
}

std::vector<std::string> ClampObjects(double max_size_m, std::vector<MapObject>* objects) {
  std::vector<std::string> notices;
  for (MapObject& object : *objects) {
    const Eigen::Vector2d size_m = object.size_m.cwiseMin(max_size_m);
    if (size_m == object.size_m) continue;
    notices.push_back(fmt::format("object '{}' is cut from {:.2f} x {:.2f} m to {:.2f} x {:.2f} m",
                                  object.name,
                                  object.size_m.x(),
                                  object.size_m.y(),
                                  size_m.x(),
                                  size_m.y()));
    object.size_m = size_m;
  }
  return notices;
}

bool Contains(const MapObject& object, const Eigen::Vector2d& point_in_map) {
  const Eigen::Vector2d point_in_object = object.map_from_object.Inverse() * point_in_map;
  return (2 * point_in_object.cwiseAbs().array() <= object.size_m.array()).all();
}

}  // namespace nightmap
