// SPDX-License-Identifier: Apache-2.0
// Reads the lines of a sensor log, which may be large and gzipped.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace nightmap {

// Calls visit(line number from 1, line without its end) for each line, and reads the file in
// pieces. Throws DataError naming the file when it is missing or no plain file, when its gzip data
// are damaged or truncated, or when a line is longer than a megabyte.
void VisitLogLines(const std::filesystem::path& path,
                   const std::function<void(int, std::string_view)>& visit);

}  // namespace nightmap
