// SPDX-License-Identifier: Apache-2.0
// Pictures of all formats, and videos. OpenImageIO, OpenCV's videos and FFmpeg bring 250 libraries,
// which take half a second to load: so they are in a module beside the programs (pipeline/media),
// which a program loads when it meets the first file that needs it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "pipeline/io/picture_file.h"

namespace nightmap {

class Media {
 public:
  virtual ~Media() = default;
  // `format` is that of FormatOfFile: no other reader opens the file. Colors as stored, not
  // multiplied by alpha. Throws DataError naming the file when it is no such picture, OutOfMemory.
  virtual std::unique_ptr<PictureFile> OpenPicture(const std::filesystem::path& path,
                                                   std::string_view format) = 0;
  // As the functions of these names in image_io.h.
  virtual ColorImage ReadVideoFrame(const std::filesystem::path& video, int frame_idx) = 0;
  virtual VideoInfo InspectVideo(const std::filesystem::path& path) = 0;
  virtual std::int64_t NumDecodedVideoFrames() = 0;
};

// The loaded module. Throws UsageError, which skips no frame, when it is missing or that of another
// build.
Media& LoadedMedia();

}  // namespace nightmap
