// SPDX-License-Identifier: Apache-2.0
// Pictures that one reader of OpenImageIO reads: what else it reads, videos and volumes, is none.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "pipeline/io/picture_file.h"

namespace nightmap::media {

// As Media::OpenPicture.
std::unique_ptr<PictureFile> OpenAnyPicture(const std::filesystem::path& path,
                                            std::string_view format);

}  // namespace nightmap::media
