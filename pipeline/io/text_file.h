// SPDX-License-Identifier: Apache-2.0
// Text files as editors and power cuts leave them.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

// The whole file, without the byte order mark that editors on Windows put in front of UTF-8. Throws
// DataError naming the file when it is UTF-16, and the line too when it holds NUL bytes, which a
// power cut leaves where it lost the text: what stands before them would pass for the whole.
std::string ReadTextFile(const std::filesystem::path& path);

// Calls visit(words) for every line that is neither empty nor a `#` comment. A DataError thrown by
// visit is thrown on with `file:line: ` in front. Throws DataError when the file cannot be read.
void VisitWordLines(const std::filesystem::path& path,
                    const std::function<void(const std::vector<std::string_view>&)>& visit);

// The words between blanks.
std::vector<std::string_view> SplitWords(std::string_view line);

// A finite number. Throws DataError quoting the word.
double RealWord(std::string_view word);

}  // namespace nightmap
