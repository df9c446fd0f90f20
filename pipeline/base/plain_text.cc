// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/plain_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace nightmap {
namespace {

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }
bool IsAscii(char c) { return static_cast<unsigned char>(c) < 0x80; }

bool IsUtf8(std::string_view text) {
  try {
    nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
  return true;
}

// U+0080 to U+009F in UTF-8 are C2 80 to C2 9F.
bool HoldsControlOfTwoBytes(std::string_view text) {
  const auto is_one = [](char lead, char byte) {
    return lead == '\xc2' && static_cast<unsigned char>(byte) < 0xa0;
  };
  return std::ranges::adjacent_find(text, is_one) != text.end();
}

}  // namespace

bool IsText(std::string_view text) {
  if (std::ranges::any_of(text, IsControl)) return false;
  if (std::ranges::all_of(text, IsAscii)) return true;
  return IsUtf8(text) && !HoldsControlOfTwoBytes(text);
}

std::string AsText(std::string_view text) {
  if (IsText(text)) return std::string(text);
  std::string escaped;
  for (const char c : text) {
    const bool is_kept = IsAscii(c) && !IsControl(c);
    escaped +=
        is_kept ? std::string(1, c) : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return escaped;
}

std::string AsLines(std::string_view message) {
  std::string lines;
  for (std::size_t begin = 0; begin <= message.size();) {
    const std::size_t end = std::min(message.find('\n', begin), message.size());
    lines += AsText(message.substr(begin, end - begin));
    if (end < message.size()) lines += '\n';
    begin = end + 1;
  }
  return lines;
}

}  // namespace nightmap
