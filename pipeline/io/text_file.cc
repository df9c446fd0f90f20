// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/text_file.h"

#include <algorithm>

#include <string>
#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"

namespace nightmap {

std::string ReadTextFile(const std::filesystem::path& path) {
  std::string text = ReadFile(path);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw DataError("{}: is text in UTF-16: store it as UTF-8", path.string());
  }
  const std::size_t first = text.find('\0');
  if (first == std::string::npos) return text;
  const auto begin = text.begin() + static_cast<std::ptrdiff_t>(first);
  throw DataError(
      "{}:{}: holds {} NUL bytes, as after a power cut: copy the file again, or delete this line "
      "and all below it; delete the file if make wrote it",
      path.string(),
      1 + std::count(text.begin(), begin, '\n'),
      std::count(begin, text.end(), '\0'));
}

std::vector<std::string_view> SplitWords(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlank, end);
  }
  return words;
}

void VisitWordLines(const std::filesystem::path& path,
                    const std::function<void(const std::vector<std::string_view>&)>& visit) {
  const std::string text = ReadTextFile(path);
  int line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const auto words = SplitWords(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    if (words.empty() || words[0].starts_with('#')) continue;
    try {
      visit(words);
    } catch (const DataError& error) {
      throw DataError("{}:{}: {}; repair the line, or delete the file if make wrote it",
                      path.string(),
                      line_number,
                      error.what());
    }
  }
}

double RealWord(std::string_view word) {
  const auto value = ParseReal(word);
  if (!value) throw DataError("'{}' is not a finite number", word);
  return *value;
}

}  // namespace nightmap
