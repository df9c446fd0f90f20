// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/segmentation_model.h"

#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/options.h"
#include "pipeline/base/plain_text.h"
#include "pipeline/io/text_file.h"

namespace nightmap {
namespace {

constexpr std::size_t kMaxClasses = 255;

// The model file as written.
struct ModelTable {
  OPTION(std::string, network, "", "ONNX file, relative to this file");
  OPTION(int, input_width_px, 0, {8, 4096}, "columns of the network's input");
  OPTION(int, input_height_px, 0, {8, 4096}, "rows of the network's input");
  OPTION(std::vector<double>, mean, std::vector<double>(3, 0.0), {-1e6, 1e6},
         "subtracted from 0 .. 255, per channel of the network");
  OPTION(std::vector<double>, scale, std::vector<double>(3, 1.0), {1e-6, 1e6},
         "divides the difference, per channel of the network");
  OPTION(std::string, channel_order, "rgb", {"rgb", "bgr"}, "of the network's input");
  OPTION(std::vector<std::string>, classes, {}, "names in the order of the network's outputs");
  OPTION(std::vector<std::string>, moving, {},
         "names of the classes of things that move by themselves");
  MovingMaskOptions mask;
  OPTION_AT("min_confidence", mask.min_confidence, {0, 1},
            "a pixel counts as moving when its class can move and is at least so probable");
  OPTION_AT("margin_px", mask.margin_px, {0, 100}, "widens what moves by so many pixels");
  OPTION(double, moving_gap_s, 0.05, {0, 1e6},
         "a frame that brings nothing new is labelled, too, so many seconds after one in which "
         "something moves");
  OPTION(double, still_gap_s, 0.3, {0, 1e6}, "... and after one in which nothing moves");
  REGISTER_OPTIONS();
};

// Names the line of a key in messages.
class KeyLines {
 public:
  KeyLines(std::string_view text, const std::string& source)
      : table_(toml::parse(text, source)), source_(source) {}

  std::string Of(const char* key) const {
    return fmt::format("{}:{}", source_, table_.get(key)->source().begin.line);
  }
  bool Has(const char* key) const { return table_.contains(key); }
  void Require(const char* key, const char* remedy) const {
    if (!Has(key)) throw UsageError("{}: '{}' is missing: {}", source_, key, remedy);
  }

 private:
  toml::table table_;
  std::string source_;
};

void RequireKeys(const KeyLines& lines) {
  if (lines.Has("network")) {
    lines.Require("input_width_px", "add the columns of the network's input");
    lines.Require("input_height_px", "add the rows of the network's input");
  }
  lines.Require("classes", "add the names of the classes in the order of the network's outputs");
  lines.Require("moving", "add the names of the classes that move by themselves, [] for none");
}

std::array<double, 3> PerChannel(const std::vector<double>& values,
                                 const char* key,
                                 const KeyLines& lines) {
  if (values.size() != 3) {
    throw UsageError(
        "{}: '{}' has {} numbers; give 3, one per channel", lines.Of(key), key, values.size());
  }
  return {values[0], values[1], values[2]};
}

void CheckClasses(const std::vector<std::string>& classes, const KeyLines& lines) {
  if (classes.size() < 2 || classes.size() > kMaxClasses) {
    throw UsageError("{}: 'classes' has {} names; give 2 .. {}, one per output of the network",
                     lines.Of("classes"),
                     classes.size(),
                     kMaxClasses);
  }
  for (const std::string& name : classes) {
    if (name.empty() || !IsText(name)) {
      throw UsageError(
          "{}: 'classes' names \"{}\", which is empty or holds control characters: give each "
          "class a name of one line",
          lines.Of("classes"),
          AsText(name));
    }
    if (std::ranges::count(classes, name) > 1) {
      throw UsageError("{}: 'classes' names \"{}\" twice: rename one", lines.Of("classes"), name);
    }
  }
}

std::vector<std::uint8_t> MovingClasses(const ModelTable& table, const KeyLines& lines) {
  std::vector<std::uint8_t> moving(table.classes.size(), 0);
  for (const std::string& name : table.moving) {
    const auto found = std::ranges::find(table.classes, name);
    if (found == table.classes.end()) {
      throw UsageError("{}: 'moving' names \"{}\", which is no class; there are: {}",
                       lines.Of("moving"),
                       name,
                       fmt::join(table.classes, ", "));
    }
    moving[static_cast<std::size_t>(found - table.classes.begin())] = 1;
  }
  return moving;
}

}  // namespace

SegmentationModel ParseSegmentationModel(std::string_view text,
                                         const std::string& source,
                                         const std::filesystem::path& folder) {
  ModelTable table;
  RegisterOptions(table).ParseToml(text, source);
  const KeyLines lines(text, source);
  RequireKeys(lines);
  CheckClasses(table.classes, lines);
  return {.source = source,
          .network = table.network.empty() ? std::filesystem::path() : folder / table.network,
          .input_width_px = table.input_width_px,
          .input_height_px = table.input_height_px,
          .mean = PerChannel(table.mean, "mean", lines),
          .scale = PerChannel(table.scale, "scale", lines),
          .is_bgr = table.channel_order == "bgr",
          .classes = {table.classes, MovingClasses(table, lines)},
          .mask = table.mask,
          .moving_gap_s = table.moving_gap_s,
          .still_gap_s = table.still_gap_s};
}

SegmentationModel ReadSegmentationModel(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) {
    throw UsageError("{}: no such model file: correct its path", path.string());
  }
  const SegmentationModel model =
      ParseSegmentationModel(ReadTextFile(path), path.string(), path.parent_path());
  if (model.HasNetwork() && !std::filesystem::is_regular_file(model.network)) {
    throw UsageError(
        "{}: found no network {}: correct 'network'", path.string(), model.network.string());
  }
  return model;
}

}  // namespace nightmap
