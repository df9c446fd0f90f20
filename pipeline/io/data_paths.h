// SPDX-License-Identifier: Apache-2.0
// Paths of files in the data folder, relative and as text, for artifacts and reports.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace nightmap {

// Replaces the whole path of `file` in the message, also in libraries' own text, by `file` itself
// (relative to the data folder): a report must not depend on where the data folder is.
std::string WithoutDataRoot(std::string message,
                            const std::filesystem::path& data_root,
                            const std::string& file);

// Whether the path is UTF-8 without control characters, so that CSV, JSON and a terminal can hold
// it. File systems allow any bytes.
bool IsText(std::string_view path);
// The path itself if it is text; otherwise with everything but printable ASCII written as \xNN.
std::string AsText(std::string_view path);

}  // namespace nightmap
