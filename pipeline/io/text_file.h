// SPDX-License-Identifier: Apache-2.0
// Reads text files, including what editors and power cuts do to them.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

// Returns the whole file without the byte order mark that editors on Windows put before UTF-8.
// Throws DataError naming the file when it is UTF-16. Throws DataError naming the line too when it
// holds NUL bytes: a power cut leaves them where text was lost, and the text before them would pass
// for the whole.
std::string ReadTextFile(const std::filesystem::path& path);

// Calls visit(words) for every line that is neither empty nor a `#` comment. Rethrows a DataError
// of visit with `file:line: ` in front. Throws DataError when the file cannot be read.
void VisitWordLines(const std::filesystem::path& path,
                    const std::function<void(const std::vector<std::string_view>&)>& visit);

// The words between blanks.
std::vector<std::string_view> SplitWords(std::string_view line);

// A finite number. Throws DataError quoting the word.
double RealWord(std::string_view word);

}  // namespace nightmap
