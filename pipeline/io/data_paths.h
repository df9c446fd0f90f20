// SPDX-License-Identifier: Apache-2.0
// Paths of files in the data folder, relative to it, for artifacts and reports.
#pragma once

#include <filesystem>
#include <string>

namespace nightmap {

// Replaces the whole path of `file` in the message, also in libraries' own text, by `file` itself
// (relative to the data folder): a report must not depend on where the data folder is.
std::string WithoutDataRoot(std::string message,
                            const std::filesystem::path& data_root,
                            const std::string& file);

}  // namespace nightmap
