// SPDX-License-Identifier: Apache-2.0
#include "pipeline/synthetic/recording_files.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "pipeline/base/files.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {

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
  const auto output = OIIO::ImageOutput::create(path.string());
  if (!output) throw DataError("{}: this build of OpenImageIO writes no JPEG", path.string());
  OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("Compression", "jpeg:95");
  const bool is_written = output->open(path.string(), spec) &&
                          output->write_image(OIIO::TypeDesc::UINT8, image.pixels.data()) &&
                          output->close();
  if (!is_written) throw DataError("{}: {}; is the disk full?", path.string(), output->geterror());
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
