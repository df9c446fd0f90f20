// SPDX-License-Identifier: Apache-2.0
// Paths of files in the data folder, as artifacts and reports hold them: relative to it, and text.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace nightmap {

// The message with `file` (relative to the data folder) wherever the file's whole path stands,
// libraries' own words included: a report must not depend on where the data folder is.
std::string WithoutDataRoot(std::string message,
                            const std::filesystem::path& data_root,
                            const std::string& file);

// Whether the path is UTF-8 without control characters, so that CSV, JSON and a terminal can hold
// it. File systems allow any bytes.
bool IsText(std::string_view path);
// The same path when it is text; else all but printable ASCII is written as \xNN.
std::string AsText(std::string_view path);

}  // namespace nightmap
