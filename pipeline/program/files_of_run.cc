// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/files_of_run.h"

#include <sys/stat.h>

#include <algorithm>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_file.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

// The path with links and dots of its folder resolved. Keeps the name, because an output replaces a
// link.
fs::path Resolve(const fs::path& path) {
  const fs::path absolute = fs::absolute(path);
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(absolute.parent_path(), error);
  return (error ? absolute.parent_path().lexically_normal() : folder) / absolute.filename();
}

std::optional<std::pair<dev_t, ino_t>> IdentityOf(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return std::nullopt;
  return std::pair{status.st_dev, status.st_ino};
}

bool IsBelow(const fs::path& path, const fs::path& folder) {
  return std::ranges::mismatch(folder, path).in1 == folder.end();
}

[[noreturn]] void RefuseOverwritten(const std::string& output, const std::string& input) {
  throw UsageError("{} is the file of {}; give the output another path", output, input);
}

}  // namespace

void FilesOfRun::AddRead(const fs::path& path, const std::string& role) {
  const auto identity = IdentityOf(path);
  if (!identity) return;
  if (const auto found = overwritten_.find(*identity); found != overwritten_.end()) {
    RefuseOverwritten(found->second, role);
  }
  read_.try_emplace(*identity, role);
}

void FilesOfRun::AddWritten(const fs::path& path, const std::string& role) {
  RequirePlaceForFile(path, role);
  const fs::path resolved = Resolve(path);
  for (const auto& [other, other_role] : written_) {
    if (other == resolved) {
      throw UsageError("{} and {} are one file; give each its own path", other_role, role);
    }
    if (IsBelow(other, resolved) || IsBelow(resolved, other)) {
      throw UsageError(
          "{} and {}: one is the folder of the other; give each its own path", other_role, role);
    }
  }
  if (const auto identity = IdentityOf(path)) {
    if (const auto found = read_.find(*identity); found != read_.end()) {
      RefuseOverwritten(role, found->second);
    }
    overwritten_.try_emplace(*identity, role);
  }
  written_.emplace(resolved, role);
}

}  // namespace nightmap
