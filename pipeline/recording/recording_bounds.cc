// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/recording_bounds.h"

#include <sys/stat.h>

#include <algorithm>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

bool IsAtOrBelow(const fs::path& path, const fs::path& place) {
  return std::mismatch(place.begin(), place.end(), path.begin(), path.end()).first == place.end();
}

}  // namespace

RecordingBounds::RecordingBounds(const SequenceFolder& folder)
    : data_root_(folder.data_root),
      data_root_text_((folder.data_root / "").string()),
      folder_(folder.folder.lexically_normal()),
      source_(folder.config.source) {
  for (const std::string& name : folder.config.allow_outside) {
    allowed_.push_back((fs::path(name) / "").lexically_normal().parent_path());
  }
  for (const fs::path& place :
       {fs::path(), folder_, folder_ / folder.config.depth_folder}) {  // those that exist
    std::error_code missing;
    const fs::path real = fs::canonical(data_root_ / place, missing);
    if (!missing) places_.push_back(real);
  }
}

bool RecordingBounds::IsAllowed(const fs::path& inside) const {
  return std::ranges::any_of(
      allowed_, [&](const fs::path& name) { return name.empty() || IsAtOrBelow(inside, name); });
}

void RecordingBounds::CheckLink(const fs::path& inside) const {
  const fs::path path = data_root_ / folder_ / inside;
  std::error_code missing;
  if (!fs::is_symlink(path, missing) || IsAllowed(inside)) return;
  const fs::path target = fs::canonical(path, missing);
  const auto holds = [&](const fs::path& place) { return IsAtOrBelow(target, place); };
  if (missing || std::ranges::any_of(places_, holds)) return;
  throw DataError(
      "{}: is a link to {}, outside of the recording and of the data folder: put the files there, "
      "or add allow_outside = [\"{}\"] to {}",
      path.string(),
      target.string(),
      inside.generic_string(),
      source_);
}

void RecordingBounds::CheckFolder(const std::string& folder) {
  if (!checked_folders_.insert(folder).second) return;
  fs::path way;
  for (const fs::path& part : fs::path(folder).lexically_relative(folder_)) {
    way /= part;
    CheckLink(way);
  }
}

// A list may have millions of lines, so most of them cost one disk access and few path objects.
void RecordingBounds::Check(const std::string& file) {
  CheckFolder(file.substr(0, std::min(file.rfind('/'), file.size())));
  struct stat status;
  if (lstat((data_root_text_ + file).c_str(), &status) != 0 || !S_ISLNK(status.st_mode)) return;
  CheckLink(fs::path(file).lexically_relative(folder_));
}

}  // namespace nightmap
