// SPDX-License-Identifier: Apache-2.0
// Files of a recording that a stage makes up.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/writing_folder.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

// A file of the recording, by its path in the folder.
struct RecordingFile {
  std::string name;
  std::string bytes;
};

// TUM list of time and file: `rgb` with extension jpg, `depth` with png.
std::string FileList(const std::vector<StampedPose>& poses,
                     const std::string& folder,
                     const std::string& extension);

// JPEG of quality 95. Equal pixels give equal bytes. Throws DataError naming the file.
void WriteJpeg(const std::filesystem::path& path, const ColorImage& image);

// Marks the folder of `summary` as made up, for make to remove, and removes `summary`, so that a
// killed run leaves no recording that looks whole. Throws DataError when the folder holds a
// recording that has no mark.
void TakeRecordingFolder(const std::filesystem::path& summary, bool holds_recording);

// Calls write(temporary path in `writing`) and renames the file. Keeps the extension, because
// writers choose the format by it.
template <typename Write>
void WriteAtomically(const std::filesystem::path& path,
                     const WritingFolder& writing,
                     const Write& write) {
  const std::string kind = path.parent_path().filename().string();
  const std::filesystem::path temporary = writing.Path() / (kind + "_" + path.filename().string());
  write(temporary);
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (error) throw DataError("{}: cannot be written: {}", path.string(), error.message());
}

}  // namespace nightmap
