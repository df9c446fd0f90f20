// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/word_lines.h"

#include <algorithm>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"

namespace nightmap {

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
