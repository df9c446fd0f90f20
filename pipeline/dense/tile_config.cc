// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/tile_config.h"

#include <toml++/toml.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/json_fields.h"

namespace nightmap {
namespace {

std::string ReadConfigOfReport(const std::filesystem::path& path) {
  try {
    return nlohmann::json::parse(ReadFile(path)).at("config").get<std::string>();
  } catch (const nlohmann::json::exception& error) {
    throw DataError("{}: {}; delete it and run make", path.string(), JsonReason(error));
  }
}

}  // namespace

TileConfig::TileConfig(const std::vector<std::filesystem::path>& reports)
    : report_(reports.at(0)), toml_(ReadConfigOfReport(report_)) {
  for (const auto& path : reports) {
    if (ReadConfigOfReport(path) == toml_) continue;
    throw DataError(
        "{}: the tile was made with another config than that of {}; delete the folder of the tiles "
        "and run make",
        path.string(),
        report_.string());
  }
}

double TileConfig::Number(const std::string& name, const Range& range) const {
  try {
    const auto value = toml::parse(toml_)[name].value<double>();
    if (value && range.min <= *value && *value <= range.max) return *value;
  } catch (const toml::parse_error&) {  // counts as no value
  }
  throw DataError("{}: its config has no {} from {} to {}; delete the report and run make",
                  report_.string(),
                  name,
                  range.min,
                  range.max);
}

int TileConfig::Integer(const std::string& name, const Range& range) const {
  const double value = Number(name, range);
  if (value == std::floor(value)) return static_cast<int>(value);
  throw DataError("{}: {} of its config is no whole number; delete the report and run make",
                  report_.string(),
                  name);
}

}  // namespace nightmap
