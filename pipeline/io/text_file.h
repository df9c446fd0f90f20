// SPDX-License-Identifier: Apache-2.0
// Reads text files, including what editors and power cuts do to them.
#pragma once

#include <filesystem>
#include <string>

namespace nightmap {

// Returns the whole file without the byte order mark that editors on Windows put before UTF-8.
// Throws DataError naming the file when it is UTF-16. Throws DataError naming the line too when it
// holds NUL bytes: a power cut leaves them where text was lost, and the text before them would pass
// for the whole.
std::string ReadTextFile(const std::filesystem::path& path);

}  // namespace nightmap
