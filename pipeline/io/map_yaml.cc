// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/map_yaml.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

std::string_view Trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// A YAML scalar without its comment and quotes.
std::string_view Scalar(std::string_view text) {
  text = Trim(text);
  if (!text.empty() && (text[0] == '"' || text[0] == '\'')) {
    const auto end = text.find(text[0], 1);
    return end == std::string_view::npos ? text : text.substr(1, end - 1);
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '#' && (i == 0 || text[i - 1] == ' ' || text[i - 1] == '\t')) {
      return Trim(text.substr(0, i));
    }
  }
  return text;
}

}  // namespace

MapYaml::MapYaml(const std::filesystem::path& path) : path_(path.string()) {
  const std::string text = ReadFile(path);
  std::size_t begin = 0;
  for (int line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    AddLine(std::string_view(text).substr(begin, end - begin), line);
    begin = end + 1;
  }
}

const std::string& MapYaml::Text(const std::string& key) const {
  const auto it = values_.find(key);
  if (it == values_.end()) throw DataError("{}: missing key '{}'", path_, key);
  if (it->second.empty()) throw DataError("{}: key '{}' has no value", path_, key);
  return it->second;
}

double MapYaml::Number(const std::string& key) const { return ParseNumber(key, Text(key)); }

double MapYaml::Fraction(const std::string& key) const {
  const double value = Number(key);
  if (value < 0 || value > 1) throw DataError("{}: {} is {}, not in [0, 1]", path_, key, value);
  return value;
}

Eigen::Vector3d MapYaml::Triple(const std::string& key) const {
  std::string_view text = Text(key);
  if (text.size() < 2 || text.front() != '[' || text.back() != ']' ||
      std::count(text.begin(), text.end(), ',') != 2) {
    throw DataError("{}: {} is '{}', not a list [x, y, yaw]", path_, key, text);
  }
  text = text.substr(1, text.size() - 2);
  Eigen::Vector3d values;
  for (int i = 0; i < 3; ++i) {
    const std::size_t end = std::min(text.find(','), text.size());
    values[i] = ParseNumber(key, Trim(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return values;
}

void MapYaml::AddLine(std::string_view line, int number) {
  if (Scalar(line).empty() || Trim(line) == "---") return;
  const auto colon = line.find(':');
  if (colon == std::string_view::npos || line[0] == ' ' || line[0] == '\t' || line[0] == '-') {
    throw DataError("{}:{}: expected `key: value`, got '{}'", path_, number, line);
  }
  const std::string key(Trim(line.substr(0, colon)));
  if (!values_.emplace(key, Scalar(line.substr(colon + 1))).second) {
    throw DataError("{}:{}: key '{}' appears twice", path_, number, key);
  }
}

double MapYaml::ParseNumber(const std::string& key, std::string_view text) const {
  const auto value = ParseReal(text.starts_with('+') ? text.substr(1) : text);
  if (!value) throw DataError("{}: {} has '{}' where a finite number is needed", path_, key, text);
  return *value;
}

}  // namespace nightmap
