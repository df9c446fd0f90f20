// SPDX-License-Identifier: Apache-2.0
// Keys and values of a YAML file, which yaml-cpp reads.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace YAML {  // NOLINT(readability-identifier-naming): yaml-cpp's name
class Node;
}

namespace nightmap {

// A mapping in which each key stands at most once. Errors are DataError naming file and line.
class YamlMap {
 public:
  // The mapping that the file's only document is. A file beyond 1 MiB, which nobody writes by hand,
  // is refused before it is parsed: no text of that size keeps the parser for more than 2 s.
  explicit YamlMap(const std::filesystem::path& path);

  // Throws when there is a key that is not `known`.
  void CheckKeys(const std::set<std::string>& known) const;
  bool Has(const std::string& key) const { return entries_.contains(key); }
  std::string Text(const std::string& key) const;
  double Number(const std::string& key, double min, double max) const;
  // 0, 1, or what YAML 1.1 takes for true or false (`yes`, `Off`, `TRUE`, ...).
  bool Flag(const std::string& key) const;
  std::vector<double> Numbers(const std::string& key) const;
  std::vector<YamlMap> Maps(const std::string& key) const;

  // Names the line of the key: an empty value has none of its own.
  [[noreturn]] void Fail(const std::string& key, std::string_view reason) const;

 private:
  struct Entry {
    int line = 0;
    std::shared_ptr<const YAML::Node> value;
  };

  YamlMap(std::string source, const YAML::Node& node);
  void AddEntries(const YAML::Node& node);
  const Entry& At(const std::string& key) const;
  const YAML::Node& List(const std::string& key) const;
  std::string Scalar(const std::string& key, const YAML::Node& node) const;
  double Finite(const std::string& key, const YAML::Node& node) const;
  [[noreturn]] void FailAt(int line, std::string_view reason) const;

  std::string source_;
  int line_ = 1;
  std::map<std::string, Entry> entries_;
};

}  // namespace nightmap
