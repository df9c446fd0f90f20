// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/recording_files.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <memory>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
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
  const std::unique_ptr<void, decltype(&tjDestroy)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  if (!encoder || tjCompress2(encoder.get(),
                              image.pixels.data(),
                              image.width,
                              0,
                              image.height,
                              TJPF_RGB,
                              &bytes,
                              &size,
                              TJSAMP_420,
                              kJpegQuality,
                              TJFLAG_ACCURATEDCT) != 0) {
    throw DataError("{}: {}", path.string(), tjGetErrorStr2(encoder.get()));
  }
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owner(bytes, tjFree);
  WriteFile(path, {reinterpret_cast<const char*>(bytes), size});
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
