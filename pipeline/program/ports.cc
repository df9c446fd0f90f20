// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/ports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
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

// Checked before reading, because an output given here by mistake may be larger than the memory.
void CheckInListFile(const fs::path& file, const std::string& text) {
  constexpr std::uintmax_t kMaxSize_bytes = 64 << 20;  // half a million paths
  if (!fs::exists(file)) {
    throw DataError("--in-list {}: the file does not exist; make it or correct the path", text);
  }
  if (const std::string why = WhyNotPlain(file); !why.empty()) {
    throw UsageError("--in-list {}: {}, a file with one path per line is needed", text, why);
  }
  if (fs::file_size(file) <= kMaxSize_bytes) return;
  throw DataError(
      "{}: {} bytes are too many for a list of inputs, {} are allowed; give --in-list "
      "a file with one path per line",
      file.string(),
      fs::file_size(file),
      kMaxSize_bytes);
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

PortSpec CheckedPort(std::string name,
                     std::string doc,
                     std::function<void(const std::filesystem::path& file)> check) {
  const auto check_alone = [check = std::move(check)](const std::filesystem::path& file,
                                                      const PortPaths&) { check(file); };
  return {std::move(name), std::move(doc), Arity::kOne, PortKind::kFile, check_alone};
}

PortSpec CheckedPort(std::string name, std::string doc, std::string base, CheckWithBase check) {
  const auto check_with_base = [base = std::move(base), check = std::move(check)](
                                   const std::filesystem::path& file, const PortPaths& given) {
    const auto found = given.find(base);
    if (found == given.end()) {
      throw UsageError("--check-config: {} refers to --in {}: give that too", file.string(), base);
    }
    check(file, found->second.front());
  };
  return {std::move(name), std::move(doc), Arity::kOne, PortKind::kFile, check_with_base};
}

void CheckFilesOfUser(const std::vector<std::string>& texts, const std::vector<PortSpec>& ports) {
  PortPaths given;
  for (const std::string& text : texts) {
    const auto [name, path] = SplitPort(text, "--in");
    given[name].push_back(path);
  }
  for (const std::string& text : texts) {
    const auto [name, path] = SplitPort(text, "--in");
    const auto port = std::ranges::find(ports, name, &PortSpec::name);
    if (port == ports.end()) {
      throw UsageError("--check-config --in {}: there is no such input; see --help", text);
    }
    if (!port->check) continue;
    CheckInput(path, *port);
    port->check(path, given);
  }
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

InList ReadInList(const std::string& text) {
  const auto [name, file] = SplitPort(text, "--in-list");
  CheckInListFile(file, text);
  InList list{file, {}};
  std::istringstream lines(ReadFile(file));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.find('\0') != std::string::npos) {
      throw DataError("{}:{}: a path is needed in each line, this one {}; correct the list",
                      file.string(),
                      list.inputs.size() + 1,
                      line.empty() ? "is empty" : "holds a NUL");
    }
    list.inputs.push_back(fmt::format("{}={}", name, line));
  }
  return list;
}

void CheckInputs(const PortPaths& inputs, const std::vector<PortSpec>& ports) {
  for (const PortSpec& port : ports) {
    for (const fs::path& path : inputs.at(port.name)) CheckInput(path, port);
  }
}

}  // namespace nightmap
