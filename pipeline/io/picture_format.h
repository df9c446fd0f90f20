// SPDX-License-Identifier: Apache-2.0
// Kind of a picture file, by its content, and how large it may be: both are known before a library
// opens it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace nightmap {

// The format of the picture whose file begins with `start`, by OpenImageIO's name of its reader;
// empty when it begins no picture.
std::string_view FormatOfPicture(std::string_view start);

// Whether `start` begins a video or an animation.
bool IsVideo(std::string_view start);

// As FormatOfPicture. Throws DataError naming the file and the remedy when it is no picture.
std::string_view FormatOfFile(const std::filesystem::path& path);

// Throws DataError when a picture cannot have this size, or is too large to decode.
void CheckPictureSize(const std::filesystem::path& path,
                      std::int64_t width,
                      std::int64_t height,
                      std::int64_t num_channels);

// As CheckPictureSize, for the sizes in a HEIF file (`ispe` boxes, ISO/IEC 23008-12): OpenImageIO
// decodes such a file when it opens it.
void CheckHeifSizes(const std::filesystem::path& path, std::string_view bytes);

}  // namespace nightmap
