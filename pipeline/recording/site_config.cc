// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/site_config.h"

#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/options.h"
#include "pipeline/io/text_file.h"
#include "pipeline/recording/layouts.h"
#include "pipeline/recording/site_tables.h"

namespace nightmap {
namespace {

// make's copy of a config has the user's text, then this line, which names the user's file.
constexpr std::string_view kTextEnd = "\n# This was the text of ";

// A [[sequence]] or [[query]] table as written.
struct SequenceTable {
  OPTIONS_OF(SequenceConfig, sequence);
  OPTION(std::string, camera, "", "id of a [[camera]]");
  REGISTER_OPTIONS();
};

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

// Checks the keys that a layout requires and those that it excludes.
void CheckKeys(const toml::table& table, const Layout& layout, const std::string& where) {
  Require(table, layout.required, where);
  Refuse(
      table, layout.refused, where, fmt::format("does not go with layout = \"{}\"", layout.name));
  for (const Layout& other : Layouts()) {
    Names keys = other.own;
    std::erase_if(keys, [&](const auto& key) { return std::ranges::count(layout.own, key) > 0; });
    Refuse(table, keys, where, fmt::format("needs layout = \"{}\"", other.name));
  }
  if (!layout.is_recording && table.contains("camera")) {
    Refuse(table, {"horizontal_fov_deg"}, where, "is known from `camera`");
  }
}

// Takes the key out of the table, because the other keys are options of one value or of numbers.
std::vector<std::string> TakeAllowOutside(toml::table& table, const std::string& source) {
  std::vector<std::string> names;
  const toml::node* list = table.get("allow_outside");
  if (!list) return names;
  const std::string where = Where(*list, source);
  if (!list->is_array()) throw UsageError("{}: 'allow_outside' must be a list of paths", where);
  for (const toml::node& item : *list->as_array()) {
    const auto name = item.value_exact<std::string>();
    if (!name || name->empty()) {
      throw UsageError("{}: 'allow_outside' must be a list of paths", where);
    }
    CheckPath(*name, "allow_outside", where);
    names.push_back(*name);
  }
  table.erase("allow_outside");
  return names;
}

SequenceConfig ParseSequence(toml::table& table,
                             const std::string& source,
                             const std::vector<RgbdCamera>& cameras) {
  const std::string where = Where(table, source);
  if (table.get_as<std::string>("layout") && table["layout"] == "pictures") {
    Refuse(table, {"allow_outside"}, where, "is for recordings: pictures may lie anywhere");
  }
  SequenceTable parsed;
  parsed.sequence.allow_outside = TakeAllowOutside(table, source);
  RegisterOptions(parsed).ParseTable(table, source);
  Require(table, {"layout"}, where);
  SequenceConfig& sequence = parsed.sequence;
  CheckKeys(table, LayoutOf(sequence.layout), where);
  sequence.camera_idx =
      table.contains("camera") ? FindCamera(cameras, parsed.camera, where) : kOwnCameras;
  if (sequence.frame_rate_hz > 0 && sequence.frame_rate_hz < kMinFrameRate_hz) {
    throw UsageError("{}: frame_rate_hz = {} is out of range; give 0 or at least {}",
                     where,
                     sequence.frame_rate_hz,
                     kMinFrameRate_hz);
  }
  sequence.source = where;
  CheckPath(sequence.folder, "folder", where);
  CheckPath(sequence.video, "video", where);
  CheckPath(sequence.depth_folder, "depth_folder", where);
  CheckPath(sequence.ground_truth, "ground_truth", where);
  CheckPath(sequence.label_folder, "label_folder", where);
  CheckPath(sequence.moving_folder, "moving_folder", where);
  CheckPath(sequence.confidence_folder, "confidence_folder", where);
  if (sequence.pictures.starts_with('/')) {
    throw UsageError("{}: pictures = \"{}\" must be relative to root", where, sequence.pictures);
  }
  return sequence;
}

// A statement of one without the other would change nothing, silently.
void CheckConfidence(const SequenceConfig& sequence, const std::vector<RgbdCamera>& cameras) {
  const RgbdCamera& camera = cameras.at(static_cast<std::size_t>(sequence.camera_idx));
  if (sequence.confidence_folder.empty() == (camera.min_confidence == 0)) return;
  if (sequence.confidence_folder.empty() && sequence.depth == "none") return;
  throw UsageError("{}: {} of the [[camera]] \"{}\": add it",
                   sequence.source,
                   sequence.confidence_folder.empty()
                       ? "'confidence_folder' is missing, which goes with min_confidence"
                       : "'confidence_folder' needs min_confidence",
                   camera.camera_id);
}

// All tables [[name]].
std::vector<toml::table*> Tables(toml::table& root, const char* name, const std::string& source) {
  std::vector<toml::table*> tables;
  toml::node* node = root.get(name);
  if (!node) return tables;
  if (!node->is_array_of_tables()) {
    throw UsageError("{}: '{}' must be written as [[{}]]", Where(*node, source), name, name);
  }
  for (toml::node& table : *node->as_array()) tables.push_back(table.as_table());
  return tables;
}

void CheckTopLevel(const SiteConfig& site, bool has_map, const std::string& source) {
  CheckPath(site.root, "root", source);
  if (site.hold_out_every == 1) {
    throw UsageError("{}: hold_out_every = 1 would leave nothing to map: give 0 or at least 2",
                     source);
  }
  if (site.sequences.empty() && site.signals.empty() && !has_map) {
    throw UsageError("{}: add a [[sequence]] of frames or a [[signal]]", source);
  }
  if (site.cameras.empty() && !(site.sequences.empty() && site.queries.empty())) {
    throw UsageError("{}: add a [[camera]]", source);
  }
}

toml::table ParseText(std::string_view text, const std::string& source) {
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    throw UsageError(
        "{}:{}: not valid TOML: {}", source, error.source().begin.line, error.description());
  }
}

void AddRobotTruth(const toml::table& root, const std::string& source, SiteConfig* site) {
  const toml::node* node = root.get("robot_truth");
  if (!node) return;
  if (!node->is_table()) {
    throw UsageError("{}: 'robot_truth' must be written as [robot_truth]", Where(*node, source));
  }
  site->robot_truth = ParseRobotTruth(*node->as_table(), source, site->sensors);
}

// Keys for the scripts, which choose and configure the jobs of a site.
constexpr const char* kOfMake[] = {"profile", "synthetic", "import"};

void AddQueries(toml::table& root, const std::string& source, SiteConfig* site) {
  for (toml::table* table : Tables(root, "query", source)) {
    if (table->contains("scans")) {
      site->scan_queries.push_back(ParseScanQuery(*table, source, *site));
      continue;
    }
    Refuse(*table, {"rig", "confidence_folder"}, Where(*table, source), "is for a [[sequence]]");
    site->queries.push_back(ParseSequence(*table, source, site->cameras));
  }
}

void AddSignals(toml::table& root, const std::string& source, SiteConfig* site) {
  for (const toml::table* table : Tables(root, "sensor", source)) {
    SensorConfig sensor = ParseSensor(*table, source);
    if (std::ranges::count(site->sensors, sensor.id, &SensorConfig::id) > 0) {
      throw UsageError("{}: a second sensor \"{}\": rename it", Where(*table, source), sensor.id);
    }
    site->sensors.push_back(std::move(sensor));
  }
  for (const toml::table* table : Tables(root, "signal", source)) {
    site->signals.push_back(ParseSignal(*table, source, site->sensors));
  }
}

SiteConfig ParseOwnText(std::string_view text, const std::string& source) {
  toml::table root = ParseText(text, source);
  SiteConfig site;
  for (const toml::table* table : Tables(root, "camera", source)) {
    AddCamera(*table, source, &site);
  }
  for (toml::table* table : Tables(root, "sequence", source)) {
    site.sequences.push_back(ParseSequence(*table, source, site.cameras));
    if (!LayoutOf(site.sequences.back().layout).is_recording) {
      throw UsageError("{}: layout = \"{}\" has no depth to map: make it a [[query]]",
                       site.sequences.back().source,
                       site.sequences.back().layout);
    }
    CheckConfidence(site.sequences.back(), site.cameras);
  }
  AddSignals(root, source, &site);
  AddQueries(root, source, &site);
  AddRobotTruth(root, source, &site);
  for (const char* name : {"camera", "sequence", "query", "sensor", "signal", "robot_truth"}) {
    root.erase(name);
  }
  const bool has_map = !!root.at_path("import.map");
  for (const char* name : kOfMake) root.erase(name);
  OptionList list;
  list.Add("root", &site.root, "folder of the site, relative to the data folder");
  list.Add("hold_out_every", &site.hold_out_every, {0, 1e6}, "every Nth frame becomes a query");
  list.ParseTable(root, source);
  CheckTopLevel(site, has_map, source);
  return site;
}

}  // namespace

SiteConfig ParseSiteConfig(std::string_view text, const std::string& source) {
  const std::size_t end = text.rfind(kTextEnd);
  if (end == std::string_view::npos) return ParseOwnText(text, source);
  std::string_view file = text.substr(end + kTextEnd.size());
  if (file.find('\n') != file.size() - 1) return ParseOwnText(text, source);
  file.remove_suffix(1);
  return ParseOwnText(text.substr(0, end + 1), std::string(file));
}

SiteConfig ReadSiteConfig(const std::filesystem::path& path) {
  return ParseSiteConfig(ReadTextFile(path), path.string());
}

void CheckSiteConfig(const std::filesystem::path& path) { ReadSiteConfig(path); }

void ParseAskedQueries(std::string_view text, SiteConfig* site) {
  toml::table root = ParseText(text, kQuerySource);
  AddQueries(root, kQuerySource, site);
  root.erase("query");
  OptionList().ParseTable(root, kQuerySource);
}

void ReadAskedQueries(const std::filesystem::path& path, SiteConfig* site) {
  ParseAskedQueries(ReadTextFile(path), site);
}

void CheckAskedQueries(const std::filesystem::path& path, const std::filesystem::path& site_path) {
  SiteConfig site = ReadSiteConfig(site_path);
  ReadAskedQueries(path, &site);
}

}  // namespace nightmap
