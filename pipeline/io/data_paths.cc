// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/data_paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace nightmap {
namespace {

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }
bool IsAscii(char c) { return static_cast<unsigned char>(c) < 0x80; }

}  // namespace

std::string WithoutDataRoot(std::string message,
                            const std::filesystem::path& data_root,
                            const std::string& file) {
  const std::string path = (data_root / file).string();
  for (std::size_t at = message.find(path); at != std::string::npos;
       at = message.find(path, at + file.size())) {
    message.replace(at, path.size(), file);
  }
  return message;
}

bool IsText(std::string_view path) {
  if (std::ranges::any_of(path, IsControl)) return false;
  if (std::ranges::all_of(path, IsAscii)) return true;
  try {
    nlohmann::json(path).dump();
  } catch (const nlohmann::json::type_error&) {  // not UTF-8
    return false;
  }
  return true;
}

std::string AsText(std::string_view path) {
  if (IsText(path)) return std::string(path);
  std::string text;
  for (const char c : path) {
    const bool is_kept = IsAscii(c) && !IsControl(c);
    text += is_kept ? std::string(1, c) : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return text;
}

}  // namespace nightmap
