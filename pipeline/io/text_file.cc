// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/text_file.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

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

}  // namespace nightmap
