// SPDX-License-Identifier: Apache-2.0
// The inputs and outputs of a stage program, --in NAME=PATH and --out NAME=PATH.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace nightmap {

enum class Arity { kOne, kOptional, kMany, kAnyNumber };
// kByHash: a file of which the run takes only what other inputs have hashes of, so that its receipt
// says nothing of the rest.
enum class PortKind { kFile, kFolder, kByHash };

using PortPaths = std::map<std::string, std::vector<std::filesystem::path>>;

struct PortSpec {
  std::string name;  // as in --in NAME=PATH
  std::string doc;
  // kMany: --in NAME=PATH may be repeated, at least once, and order is kept; kAnyNumber: may also
  // be left out
  Arity arity = Arity::kOne;
  PortKind kind = PortKind::kFile;
  // Reads a file that a user writes, and throws what is wrong with it; --check-config calls it with
  // all the files that it gets.
  std::function<void(const std::filesystem::path& file, const PortPaths& given)> check = {};
};

// An input that is a folder.
inline PortSpec FolderPort(std::string name, std::string doc, Arity arity = Arity::kOne) {
  return {std::move(name), std::move(doc), arity, PortKind::kFolder};
}

// An input that a user writes.
PortSpec CheckedPort(std::string name,
                     std::string doc,
                     std::function<void(const std::filesystem::path& file)> check);

// An input that a user writes and that refers to what another input, `base`, holds.
using CheckWithBase =
    std::function<void(const std::filesystem::path& file, const std::filesystem::path& base)>;
PortSpec CheckedPort(std::string name, std::string doc, std::string base, CheckWithBase check);

// Lines for --help.
std::string PortHelp(const std::vector<PortSpec>& ports);

// Paths of each port from texts NAME=PATH after `flag`. Throws UsageError when a name is unknown,
// missing, or given too often.
PortPaths AssignPorts(const std::vector<std::string>& texts,
                      const std::vector<PortSpec>& ports,
                      const std::string& flag);

// Checks the files that texts NAME=PATH give to checked ports, and reads no others. Throws
// UsageError for an unknown name, and what the checks throw.
void CheckFilesOfUser(const std::vector<std::string>& texts, const std::vector<PortSpec>& ports);

// The inputs that NAME=FILE after --in-list stands for.
struct InList {
  std::filesystem::path file;
  std::vector<std::string> inputs;  // NAME=PATH for each line of the file, in order
};

// Reads the inputs from a file with one path per line, because a command line is too short for
// thousands. Throws UsageError when the text is not NAME=FILE or FILE is no plain file; DataError
// naming the line when a line is empty or holds a NUL, and when FILE is missing or larger than 64
// MiB.
InList ReadInList(const std::string& text);

// Throws DataError when an input does not exist, UsageError when it is not the required file or
// folder (a FIFO, for example, on which a reader would block).
void CheckInputs(const PortPaths& inputs, const std::vector<PortSpec>& ports);

}  // namespace nightmap
