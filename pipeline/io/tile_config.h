// SPDX-License-Identifier: Apache-2.0
// The config with which the tiles of a site were made. What joins tiles reads it from their reports
// instead of having such options of its own, which could disagree with the tiles.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/options.h"

namespace nightmap {

class TileConfig {
 public:
  // Reads the effective config that every report_X_Y.json has. Throws DataError naming the file
  // when one has none or another than the first; there must be at least one report.
  explicit TileConfig(const std::vector<std::filesystem::path>& reports);

  // The value of an option. Throws DataError naming the report when it is not there, no number, or
  // out of range.
  double Number(const std::string& name, const Range& range) const;
  // The same of an option that is a whole number.
  int Integer(const std::string& name, const Range& range) const;

 private:
  std::filesystem::path report_;  // the first
  std::string toml_;
};

}  // namespace nightmap
