// SPDX-License-Identifier: Apache-2.0
// Frames of video files, for image_io.h.
#include <string>

#include "pipeline/io/csv.h"
#include "pipeline/io/image_io.h"
#include "pipeline/io/media.h"

namespace nightmap {

VideoInfo InspectVideo(const std::filesystem::path& path) {
  return LoadedMedia().InspectVideo(path);
}

std::int64_t NumDecodedVideoFrames() { return LoadedMedia().NumDecodedVideoFrames(); }

std::filesystem::path VideoFramePath(const std::filesystem::path& video, int frame_idx) {
  return video.string() + '#' + std::to_string(frame_idx);
}

std::optional<std::pair<std::filesystem::path, int>> SplitVideoFramePath(
    const std::filesystem::path& path) {
  const std::string text = path.string();
  const std::size_t hash = text.rfind('#');
  if (hash == std::string::npos) return std::nullopt;
  const auto frame_idx = ParseInteger(std::string_view(text).substr(hash + 1));
  if (!frame_idx || *frame_idx < 0 || *frame_idx > 1'000'000'000) return std::nullopt;
  return std::pair(std::filesystem::path(text.substr(0, hash)), static_cast<int>(*frame_idx));
}

}  // namespace nightmap
