// SPDX-License-Identifier: Apache-2.0
// The part of YAML that map_server's files use: top-level `key: value` lines with comments and
// quotes, and one list of three numbers. Refuses anything else.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace nightmap {

// Errors are DataError naming the file and the key (or line).
class MapYaml {
 public:
  explicit MapYaml(const std::filesystem::path& path);

  bool Has(const std::string& key) const { return values_.count(key) > 0; }
  const std::string& Text(const std::string& key) const;
  double Number(const std::string& key) const;           // finite
  double Fraction(const std::string& key) const;         // in [0, 1]
  Eigen::Vector3d Triple(const std::string& key) const;  // [x, y, yaw]

 private:
  void AddLine(std::string_view line, int number);
  double ParseNumber(const std::string& key, std::string_view text) const;

  std::string path_;
  std::map<std::string, std::string> values_;
};

}  // namespace nightmap
