// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/recording_files.h"

#include <fmt/format.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/picture_file.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

constexpr int kJpegQuality = 95;

}  // namespace

std::string FileList(const std::vector<StampedPose>& poses,
                     const std::string& folder,
                     const std::string& extension) {
  std::string text = "# time_s file\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    text += fmt::format("{} {}/{:06}.{}\n", TimeToString(poses[i].time_ns), folder, i, extension);
  }
  return text;
}

void WriteJpeg(const std::filesystem::path& path, const ColorImage& image) {
  WriteFile(path, EncodeJpeg(image, kJpegQuality, JpegColors::kSubsampled));
}

void TakeRecordingFolder(const std::filesystem::path& summary, bool holds_recording) {
  const std::filesystem::path folder = summary.parent_path();
  const std::filesystem::path marker = folder / ".made_by_synthesize";
  if (holds_recording && !std::filesystem::exists(marker) && !std::filesystem::exists(summary)) {
    throw DataError("{}: holds a recording that synthesize did not make; give another folder",
                    folder.string());
  }
  WriteFile(marker, "");
  std::filesystem::remove(summary);
}

}  // namespace nightmap
