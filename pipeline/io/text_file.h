// SPDX-License-Identifier: Apache-2.0
// Text files as editors and power cuts leave them.
#pragma once

#include <filesystem>
#include <string>

namespace nightmap {

// The whole file, without the byte order mark that editors on Windows put in front of UTF-8. Throws
// DataError naming the file when it is UTF-16, and the line too when it holds NUL bytes, which a
// power cut leaves where it lost the text: what stands before them would pass for the whole.
std::string ReadTextFile(const std::filesystem::path& path);

}  // namespace nightmap
