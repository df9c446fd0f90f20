// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/things_io.h"

#include <fmt/format.h>

#include <exception>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/json_fields.h"

namespace nightmap {
namespace {

using ThingJson = nlohmann::ordered_json;

constexpr const char* kThingsFormat = "nightmap_things";
constexpr int kThingsVersion = 1;
constexpr double kMaxReach_m = 1e8;  // up to here a double resolves micrometres

ThingJson ViewToJson(const ThingView& view) {
  return {{"time_ns", view.time_ns},
          {"color_path", view.color_path},
          {"rectangle_px", view.rectangle_px}};
}

ThingJson ThingToJson(const Thing& thing) {
  const Eigen::Vector2d& centre = thing.map_from_thing.translation;
  const Eigen::Vector3d& size_m = thing.size_m;
  ThingJson json = {{"name", thing.name},
                    {"class", thing.class_name},
                    {"x_m", centre.x()},
                    {"y_m", centre.y()},
                    {"heading_rad", thing.map_from_thing.heading_rad},
                    {"bottom_m", thing.bottom_m},
                    {"size_m", {size_m.x(), size_m.y(), size_m.z()}},
                    {"num_views", thing.num_views},
                    {"confidence", thing.confidence}};
  if (thing.best_view) json["best_view"] = ViewToJson(*thing.best_view);
  return json;
}

std::string TextAt(const ThingJson& json, const char* name) {
  std::string text = json.at(name).get<std::string>();
  if (text.empty()) throw DataError("{} is empty", name);
  return text;
}

double NumberAt(const ThingJson& json, const char* name, double min, double max) {
  const double value = FiniteAt(json, name);
  if (value < min || value > max) {
    throw DataError("{} is {}, not in [{}, {}]", name, value, min, max);
  }
  return value;
}

double PositionAt(const ThingJson& json, const char* name) {
  return NumberAt(json, name, -kMaxReach_m, kMaxReach_m);
}

Eigen::Vector3d SizeAt(const ThingJson& json, const char* name) {
  const auto values = json.at(name).get<std::vector<double>>();
  if (values.size() != 3) throw DataError("{} has {} numbers, not 3", name, values.size());
  const Eigen::Vector3d size_m(values[0], values[1], values[2]);
  if (!(size_m.array() > 0).all() || !(size_m.array() <= kMaxReach_m).all()) {
    throw DataError("{} is not above 0 and at most {}", name, kMaxReach_m);
  }
  return size_m;
}

std::int64_t TimeAt(const ThingJson& json, const char* name) {
  const ThingJson& time = json.at(name);
  const bool is_integer = time.is_number_integer();
  const bool wraps =
      time.is_number_unsigned() &&
      time.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
  if (!is_integer || wraps) throw DataError("{} is no integer of 64 bits", name);
  return time.get<std::int64_t>();
}

std::array<int, 4> RectangleAt(const ThingJson& json, const char* name) {
  constexpr const char* kSides[] = {"left", "top", "right", "bottom"};
  const ThingJson& list = json.at(name);
  if (!list.is_array() || list.size() != 4) throw DataError("{} is no list of 4 numbers", name);
  ThingJson sides;
  for (std::size_t i = 0; i < 4; ++i) sides[kSides[i]] = list[i];
  std::array<int, 4> rectangle_px{};
  for (std::size_t i = 0; i < 4; ++i) rectangle_px[i] = IntegerAt(sides, kSides[i]);
  if (rectangle_px[0] >= rectangle_px[2] || rectangle_px[1] >= rectangle_px[3]) {
    throw DataError("{} has no extent", name);
  }
  return rectangle_px;
}

Thing ThingFromJson(const ThingJson& json) {
  Thing thing;
  thing.name = TextAt(json, "name");
  thing.class_name = TextAt(json, "class");
  thing.map_from_thing = {FiniteAt(json, "heading_rad"),
                          {PositionAt(json, "x_m"), PositionAt(json, "y_m")}};
  thing.bottom_m = PositionAt(json, "bottom_m");
  thing.size_m = SizeAt(json, "size_m");
  thing.num_views = IntegerAt(json, "num_views");
  thing.confidence = NumberAt(json, "confidence", 0, 1);
  if (json.contains("best_view")) {
    const ThingJson& view = json.at("best_view");
    thing.best_view = {
        TimeAt(view, "time_ns"), TextAt(view, "color_path"), RectangleAt(view, "rectangle_px")};
  }
  return thing;
}

// "thing 3 ('sofa_2')"; its name only if it has one.
std::string WhichThing(const ThingJson& json, std::size_t i) {
  const std::string number = fmt::format("thing {}", i + 1);
  if (!json.is_object() || !json.contains("name") || !json.at("name").is_string()) return number;
  return fmt::format("{} ('{}')", number, json.at("name").get<std::string>());
}

std::vector<Thing> ThingsFromJson(const ThingJson& json) {
  if (json.at("format").get<std::string>() != kThingsFormat) {
    throw DataError("format is not '{}'", kThingsFormat);
  }
  if (IntegerAt(json, "version", 1) > kThingsVersion) {
    throw DataError("version is newer than {}: update nightmap", kThingsVersion);
  }
  const ThingJson& list = json.at("things");
  if (!list.is_array()) throw DataError("things is no list");
  std::vector<Thing> things;
  std::set<std::string> names;
  for (const ThingJson& entry : list) {
    try {
      Thing thing = ThingFromJson(entry);
      if (!names.insert(thing.name).second) throw DataError("the name appears twice");
      things.push_back(std::move(thing));
    } catch (const std::exception& error) {
      const std::string reason = JsonReason(error);
      throw DataError("{}: {}", WhichThing(entry, things.size()), reason);
    }
  }
  return things;
}

}  // namespace

std::string ThingsToJson(const std::vector<Thing>& things) {
  const ThingJson head = {
      {"format", kThingsFormat},
      {"version", kThingsVersion},
      {"units",
       "x_m, y_m, heading_rad: map_from_thing, footprint's centre and the way the front looks; "
       "size_m: along x, y of the thing and z; rectangle_px: left, top, and behind the last column "
       "and row"}};
  std::string text = head.dump(1);
  text.erase(text.size() - 2);  // the closing brace and the line break before it
  text += ",\n \"things\": [";
  for (const Thing& thing : things) {
    text += text.back() == '[' ? "\n  " : ",\n  ";
    try {
      text += ThingToJson(thing).dump();
    } catch (const ThingJson::type_error&) {
      throw DataError("thing '{}': a name is not UTF-8, rename it", thing.name);
    }
  }
  return text + "\n ]\n}\n";
}

std::vector<Thing> ReadThings(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  try {
    return ThingsFromJson(ThingJson::parse(text));
  } catch (const std::exception& error) {
    throw DataError("{}: {}; delete it and run make map", path.string(), JsonReason(error));
  }
}

}  // namespace nightmap
