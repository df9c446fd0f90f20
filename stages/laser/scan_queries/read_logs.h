// SPDX-License-Identifier: Apache-2.0
// Reads the logs that [[query]] tables name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/recording/site_config.h"
#include "stages/laser/scan_queries/scan_queries.h"

namespace nightmap {

struct ScanLogs {
  std::vector<ScanLog> logs;          // one per SiteConfig::scan_queries, in their order
  std::vector<std::string> problems;  // one per line that was left out: file:line: reason
};

// Leaves out lines that are no scan, with their reason. Throws DataError naming file and remedy
// when a log cannot be read or holds no scan, and when more than max_failed_ratio of its lines are
// left out. Deterministic.
ScanLogs ReadScanLogs(const SiteConfig& site,
                      const std::filesystem::path& data_root,
                      double max_failed_ratio);

}  // namespace nightmap
