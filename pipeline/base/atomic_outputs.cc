// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/atomic_outputs.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/plain_file.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

// Data must be on disk before the name points to it, or a power cut leaves an empty file.
void FlushToDisk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0)
    throw DataError("{}: cannot open to flush: {}", path.string(), std::strerror(errno));
  const int status = fsync(descriptor);
  const std::string reason = std::strerror(errno);
  close(descriptor);
  if (status != 0) throw DataError("{}: cannot flush to disk: {}", path.string(), reason);
}

// Best effort: some file systems cannot flush folders, and the files are on disk already.
void FlushFolder(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

fs::path FolderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

bool SameBytes(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::exists(b, ignored) && fs::file_size(a) == fs::file_size(b) &&
         HashFile(a) == HashFile(b);
}

}  // namespace

fs::path OutputSet::Create(const fs::path& final_path, bool keep_if_equal) {
  if (std::ranges::count(entries_, final_path, &Entry::final_path) > 0) {
    throw UsageError("{}: is the path of two outputs; give each its own", final_path.string());
  }
  const fs::path folder = FolderOf(final_path);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw DataError("{}: cannot create folder: {}", folder.string(), error.message());
  // Keeps the name, because some writers choose the format by its extension.
  const fs::path temporary_path =
      folders_.try_emplace(folder, folder).first->second.Path() / final_path.filename();
  entries_.push_back({final_path, temporary_path, keep_if_equal});
  return temporary_path;
}

void OutputSet::Commit() {
  for (const Entry& entry : entries_) {
    if (!fs::exists(entry.temporary_path)) {
      throw DataError("{}: was announced but not written", entry.final_path.string());
    }
    RequirePlaceForFile(entry.final_path, entry.final_path.string());
    FlushToDisk(entry.temporary_path);
  }
  for (const Entry& entry : entries_) {
    if (entry.keep_if_equal && SameBytes(entry.temporary_path, entry.final_path)) {
      fs::remove(entry.temporary_path);
      continue;
    }
    fs::rename(entry.temporary_path, entry.final_path);
  }
  // A rename survives a power cut only once its folder is on disk.
  for (const auto& [folder, writing] : folders_) FlushFolder(folder);
  folders_.clear();
  committed_ = true;
}

std::vector<fs::path> OutputSet::FinalPaths() const {
  std::vector<fs::path> paths;
  for (const Entry& entry : entries_) paths.push_back(entry.final_path);
  return paths;
}

fs::path OutputSet::CurrentPath(const fs::path& final_path) const {
  if (committed_) return final_path;
  for (const Entry& entry : entries_) {
    if (entry.final_path == final_path) return entry.temporary_path;
  }
  return final_path;
}

}  // namespace nightmap
