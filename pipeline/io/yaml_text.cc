// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/yaml_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

// The character at the begin of a text, and the bytes that it takes.
struct Utf8Char {
  char32_t code = 0;
  std::size_t num_bytes = 1;
};

// None: not UTF-8 (RFC 3629: also overlong forms, surrogates, beyond U+10FFFF).
std::optional<Utf8Char> FirstChar(std::string_view text) {
  constexpr char32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};  // by bytes
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return Utf8Char{byte(0), 1};
  const std::size_t num_bytes = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4 || num_bytes > text.size()) return std::nullopt;
  char32_t code = byte(0) & (0x7FU >> num_bytes);
  for (std::size_t i = 1; i < num_bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return std::nullopt;
    code = (code << 6) | (byte(i) & 0x3FU);
  }
  if (code < kSmallest[num_bytes] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) {
    return std::nullopt;
  }
  return Utf8Char{code, num_bytes};
}

// Whether every reader of YAML takes the character as it stands (YAML 1.1 and 1.2, section 5.1).
bool IsPrintable(char32_t code) {
  if (code < 0xA0) return code >= 0x20 && code < 0x7F;
  return code != 0x2028 && code != 0x2029 && code != 0xFEFF && code != 0xFFFE && code != 0xFFFF;
}

}  // namespace

std::string QuotedForYaml(std::string_view text) {
  std::string quoted = "\"";
  for (std::string_view rest = text; !rest.empty();) {
    const auto first = FirstChar(rest);
    if (!first) throw DataError("the name '{}' is not UTF-8", text);
    if (first->code == '"' || first->code == '\\') quoted += '\\';
    if (IsPrintable(first->code)) {
      quoted += rest.substr(0, first->num_bytes);
    } else {
      quoted += fmt::format("\\u{:04X}", static_cast<std::uint32_t>(first->code));
    }
    rest.remove_prefix(first->num_bytes);
  }
  return quoted + "\"";
}

void CheckUtf8(const std::string& source, std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto first = FirstChar(text.substr(at));
    if (!first) {
      const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
      throw DataError("{}:{}: not UTF-8: store the file as UTF-8", source, line);
    }
    at += first->num_bytes;
  }
}

}  // namespace nightmap
