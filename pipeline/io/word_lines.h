// SPDX-License-Identifier: Apache-2.0
// Text files of blank-separated words, as the RGB-D benchmarks use: lists, trajectories, matrices.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

namespace nightmap {

// Calls visit(words) for every line that is neither empty nor a `#` comment. Rethrows a DataError
// of visit with `file:line: ` in front. Throws DataError when the file cannot be read.
void VisitWordLines(const std::filesystem::path& path,
                    const std::function<void(const std::vector<std::string_view>&)>& visit);

// The words between blanks.
std::vector<std::string_view> SplitWords(std::string_view line);

// A finite number. Throws DataError quoting the word.
double RealWord(std::string_view word);

}  // namespace nightmap
