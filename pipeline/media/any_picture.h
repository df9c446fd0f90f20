// SPDX-License-Identifier: Apache-2.0
// Pictures of all formats that OpenImageIO reads.
#pragma once

#include <filesystem>
#include <memory>

#include "pipeline/io/picture_file.h"

namespace nightmap::media {

// As Media::OpenPicture.
std::unique_ptr<PictureFile> OpenAnyPicture(const std::filesystem::path& path);

}  // namespace nightmap::media
