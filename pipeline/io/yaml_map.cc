// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/yaml_map.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/yaml_text.h"

namespace nightmap {
namespace {

constexpr std::uintmax_t kMaxYaml_bytes = std::uintmax_t{1} << 20;

// A mark counts lines from 0; that of an error without a place is -1.
int LineOf(const YAML::Mark& mark) { return std::max(1, mark.line + 1); }

std::string ReadYamlText(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto size_bytes = std::filesystem::file_size(path, ignored);
  if (!ignored && size_bytes > kMaxYaml_bytes) {
    throw DataError("{}: {} bytes, a YAML file has at most {}: check that it is the right file",
                    path.string(),
                    size_bytes,
                    kMaxYaml_bytes);
  }
  std::string text = ReadTextFile(path);
  CheckUtf8(path.string(), text);
  return text;
}

// A marker at a file's begin or end leaves empty documents beside the one that is meant.
YAML::Node OnlyDocument(const std::string& source, const std::string& text) {
  try {
    std::vector<YAML::Node> documents = YAML::LoadAll(text);
    std::erase_if(documents, [](const YAML::Node& document) { return document.IsNull(); });
    if (documents.size() == 1) return documents.front();
  } catch (const YAML::Exception& error) {
    throw DataError("{}:{}: not valid YAML: {}: correct this line, or copy the file again",
                    source,
                    LineOf(error.mark),
                    error.msg);
  }
  throw DataError("{}:1: expected one YAML document", source);
}

}  // namespace

YamlMap::YamlMap(const std::filesystem::path& path) : source_(path.string()) {
  AddEntries(OnlyDocument(source_, ReadYamlText(path)));
}

YamlMap::YamlMap(std::string source, const YAML::Node& node) : source_(std::move(source)) {
  AddEntries(node);
}

void YamlMap::AddEntries(const YAML::Node& node) {
  line_ = LineOf(node.Mark());
  if (!node.IsMap()) FailAt(line_, "expected keys and values");
  for (const auto& entry : node) {
    const int line = LineOf(entry.first.Mark());
    if (!entry.first.IsScalar()) FailAt(line, "a key is not a single word");
    const std::string& key = entry.first.Scalar();
    if (Has(key)) FailAt(line, fmt::format("key '{}' appears twice: delete one", key));
    entries_.emplace(key, Entry{line, std::make_shared<const YAML::Node>(entry.second)});
  }
}

void YamlMap::CheckKeys(const std::set<std::string>& known) const {
  for (const auto& [key, entry] : entries_) {
    if (known.contains(key)) continue;
    Fail(key, fmt::format("unknown key '{}'; known: {}", key, fmt::join(known, ", ")));
  }
}

std::string YamlMap::Text(const std::string& key) const { return Scalar(key, *At(key).value); }

double YamlMap::Number(const std::string& key, double min, double max) const {
  const double value = Finite(key, *At(key).value);
  if (value >= min && value <= max) return value;
  Fail(key, fmt::format("{} is {}, not in [{}, {}]", key, Text(key), min, max));
}

bool YamlMap::Flag(const std::string& key) const {
  const std::string text = Text(key);
  bool flag = false;
  if (YAML::convert<bool>::decode(*At(key).value, flag)) return flag;
  const auto value = ParseReal(text);
  if (value == 0 || value == 1) return value == 1;
  Fail(key, fmt::format("{} is '{}': write 0 or 1, or false or true", key, text));
}

std::vector<double> YamlMap::Numbers(const std::string& key) const {
  std::vector<double> numbers;
  for (const YAML::Node& item : List(key)) numbers.push_back(Finite(key, item));
  return numbers;
}

std::vector<YamlMap> YamlMap::Maps(const std::string& key) const {
  std::vector<YamlMap> maps;
  for (const YAML::Node& item : List(key)) maps.push_back(YamlMap(source_, item));
  return maps;
}

void YamlMap::Fail(const std::string& key, std::string_view reason) const {
  FailAt(At(key).line, reason);
}

const YamlMap::Entry& YamlMap::At(const std::string& key) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) FailAt(line_, fmt::format("missing key '{}': add it", key));
  return entry->second;
}

const YAML::Node& YamlMap::List(const std::string& key) const {
  const YAML::Node& list = *At(key).value;
  if (!list.IsSequence()) Fail(key, fmt::format("{} is not a list", key));
  return list;
}

std::string YamlMap::Scalar(const std::string& key, const YAML::Node& node) const {
  if (node.IsNull()) Fail(key, fmt::format("{} has no value", key));
  if (!node.IsScalar()) Fail(key, fmt::format("{} is not a single value", key));
  return node.Scalar();
}

double YamlMap::Finite(const std::string& key, const YAML::Node& node) const {
  const std::string text = Scalar(key, node);
  const auto value = ParseReal(text.starts_with('+') ? text.substr(1) : text);
  if (!value) Fail(key, fmt::format("{} is '{}', not a finite number", key, text));
  return *value;
}

void YamlMap::FailAt(int line, std::string_view reason) const {
  throw DataError("{}:{}: {}", source_, line, reason);
}

}  // namespace nightmap
