// SPDX-License-Identifier: Apache-2.0
// The config that made a site's tiles. Stages that join tiles read it from the tiles' reports.
// Options of their own could disagree with the tiles.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/options.h"

namespace nightmap {

class TileConfig {
 public:
  // Reads the effective config from every report_X_Y.json. Throws DataError naming the file when
  // one has none or differs from the first; there must be at least one report.
  explicit TileConfig(const std::vector<std::filesystem::path>& reports);

  // The value of an option. Throws DataError naming the report when it is missing, not a number, or
  // out of range.
  double Number(const std::string& name, const Range& range) const;
  // Likewise for an option that is an integer.
  int Integer(const std::string& name, const Range& range) const;

 private:
  std::filesystem::path report_;  // first report
  std::string toml_;
};

}  // namespace nightmap
