// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/ports.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_file.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

const char* ArityText(Arity arity) {
  if (arity == Arity::kOptional) return " (optional)";
  if (arity == Arity::kAnyNumber) return " (optional, may be repeated)";
  return arity == Arity::kMany ? " (may be repeated)" : "";
}

std::pair<std::string, fs::path> SplitPort(const std::string& text, const std::string& flag) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw UsageError("{} {}: write NAME=PATH", flag, text);
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

void CheckInput(const fs::path& path, const PortSpec& port) {
  if (!fs::exists(path)) {
    throw DataError(
        "{}: input '{}' does not exist; make it or correct the path", path.string(), port.name);
  }
  const bool is_folder = port.kind == PortKind::kFolder;
  const std::string why = WhyNotPlain(path);
  if (is_folder ? fs::is_directory(path) : why.empty()) return;
  throw UsageError("--in {}={}: {}, a {} is needed ({})",
                   port.name,
                   path.string(),
                   why.empty() ? "is a file" : why,
                   is_folder ? "folder" : "file",
                   port.doc);
}

}  // namespace

std::string PortHelp(const std::vector<PortSpec>& ports) {
  std::string text;
  for (const PortSpec& port : ports) {
    text += fmt::format("  {:<12} {}{}\n", port.name, port.doc, ArityText(port.arity));
  }
  return text;
}

PortPaths AssignPorts(const std::vector<std::string>& texts,
                      const std::vector<PortSpec>& ports,
                      const std::string& flag) {
  PortPaths paths;
  for (const std::string& text : texts) {
    const auto [name, path] = SplitPort(text, flag);
    if (std::ranges::count(ports, name, &PortSpec::name) == 0) {
      throw UsageError("{} {}: no such name; see --help", flag, text);
    }
    paths[name].push_back(path);
  }
  for (const PortSpec& port : ports) {
    const std::size_t count = paths[port.name].size();
    const bool needed = port.arity == Arity::kOne || port.arity == Arity::kMany;
    const bool repeatable = port.arity == Arity::kMany || port.arity == Arity::kAnyNumber;
    if (count == 0 && needed) {
      throw UsageError("{} {}=PATH is missing ({}){}",
                       flag,
                       port.name,
                       port.doc,
                       port.arity == Arity::kMany ? ": a site without frames has none" : "");
    }
    if (count > 1 && !repeatable) {
      throw UsageError("{} {} is given {} times, once is right", flag, port.name, count);
    }
  }
  return paths;
}

void CheckInputs(const PortPaths& inputs, const std::vector<PortSpec>& ports) {
  for (const PortSpec& port : ports) {
    for (const fs::path& path : inputs.at(port.name)) CheckInput(path, port);
  }
}

}  // namespace nightmap
