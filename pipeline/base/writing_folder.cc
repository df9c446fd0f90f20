// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/writing_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRandom = "XXXXXX";  // mkdtemp replaces these by six random letters

std::string Prefix() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return ".writing." + std::string(host.data()) + ".";
}

int OpenFolder(const fs::path& path) {
  return open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

// Leaves a folder alone while a running process holds its lock, and always on a file system without
// locks.
void RemoveIfDead(const fs::path& path) {
  const int descriptor = OpenFolder(path);
  if (descriptor < 0) return;
  std::error_code ignored;
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) fs::remove_all(path, ignored);
  close(descriptor);
}

void RemoveLeftBehind(const fs::path& parent) {
  const std::string prefix = Prefix();
  std::vector<fs::path> found;
  std::error_code error;
  for (auto entry = fs::directory_iterator(parent, error); !error && entry != fs::end(entry);
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    // (A further dot means that it belongs to a host with a longer name.)
    if (name.starts_with(prefix) && name.find('.', prefix.size()) == std::string::npos) {
      found.push_back(entry->path());
    }
  }
  for (const fs::path& path : found) RemoveIfDead(path);
}

}  // namespace

WritingFolder::WritingFolder(const fs::path& folder) {
  const fs::path parent = folder.empty() ? fs::path(".") : folder;
  RemoveLeftBehind(parent);
  do {
    if (lock_ >= 0) close(lock_);
    std::string name = (parent / (Prefix() + std::string(kRandom))).string();
    if (mkdtemp(name.data()) == nullptr) {
      throw DataError("{}: cannot write there: {}; correct its permissions or free space",
                      parent.string(),
                      std::strerror(errno));
    }
    path_ = name;
    lock_ = OpenFolder(path_);
    flock(lock_, LOCK_EX);
  } while (!fs::exists(path_));  // another run removed it before the lock was held
}

WritingFolder::~WritingFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (lock_ >= 0) close(lock_);
}

}  // namespace nightmap
