// SPDX-License-Identifier: Apache-2.0
// The lines of a sensor's log, which may be large and gzipped.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace nightmap {

// Calls visit(line number from 1, line without its end) for each line, reading a piece at a time.
// Throws DataError naming the file when it is missing, no plain file, its gzip data are damaged or
// cut off, or a line is longer than a megabyte.
void VisitLogLines(const std::filesystem::path& path,
                   const std::function<void(int, std::string_view)>& visit);

}  // namespace nightmap
