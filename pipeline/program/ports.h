// SPDX-License-Identifier: Apache-2.0
// The inputs and outputs of a stage program, --in NAME=PATH and --out NAME=PATH.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace nightmap {

enum class Arity { kOne, kOptional, kMany, kAnyNumber };
enum class PortKind { kFile, kFolder };

struct PortSpec {
  std::string name;  // as in --in NAME=PATH
  std::string doc;
  // kMany: --in NAME=PATH may be repeated, order kept, at least once; kAnyNumber: or left out
  Arity arity = Arity::kOne;
  PortKind kind = PortKind::kFile;
};

// An input that is a folder.
inline PortSpec FolderPort(std::string name, std::string doc, Arity arity = Arity::kOne) {
  return {std::move(name), std::move(doc), arity, PortKind::kFolder};
}

using PortPaths = std::map<std::string, std::vector<std::filesystem::path>>;

// Lines for --help.
std::string PortHelp(const std::vector<PortSpec>& ports);

// The paths of each port, of texts NAME=PATH after `flag`. Throws UsageError when a name is
// unknown, missing, or given too often.
PortPaths AssignPorts(const std::vector<std::string>& texts,
                      const std::vector<PortSpec>& ports,
                      const std::string& flag);

// The inputs that a text NAME=FILE after --in-list stands for.
struct InList {
  std::filesystem::path file;
  std::vector<std::string> inputs;  // NAME=PATH for each line of the file, in order
};

// A command line is too short for thousands of inputs, so a file has their paths, one per line.
// Throws UsageError when the text is not NAME=FILE or FILE is no plain file, DataError naming the
// line when one is empty or holds a NUL, and when FILE is not there or is larger than 64 MiB.
InList ReadInList(const std::string& text);

// Throws DataError when an input does not exist, UsageError when it is no file where one is needed
// (a FIFO, say, which a reader would wait for), or no folder.
void CheckInputs(const PortPaths& inputs, const std::vector<PortSpec>& ports);

}  // namespace nightmap
