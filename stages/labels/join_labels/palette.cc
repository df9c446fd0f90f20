// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/join_labels/palette.h"

#include <charconv>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

// Spreads the bits of the index over the channels, as PASCAL VOC's development kit does.
Rgb VocColor(std::size_t index) {
  Rgb color = {0, 0, 0};
  for (int bit = 7; index > 0; --bit, index >>= 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      color[c] = static_cast<std::uint8_t>(color[c] | ((index >> c & 1) << bit));
    }
  }
  return color;
}

Rgb ParseColor(const std::string& text) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const bool has_form = text.size() == 7 && text[0] == '#';
  const auto parsed = std::from_chars(text.data() + (has_form ? 1 : 0), end, value, 16);
  if (!has_form || parsed.ec != std::errc() || parsed.ptr != end) {
    throw UsageError("option palette: \"{}\" is no color; write \"#rrggbb\"", text);
  }
  constexpr std::uint32_t kWhite = 0xffffff;
  if (value == kWhite) value = 0xfffffe;
  return {static_cast<std::uint8_t>(value >> 16),
          static_cast<std::uint8_t>(value >> 8),
          static_cast<std::uint8_t>(value)};
}

}  // namespace

std::vector<Rgb> MakePalette(const std::vector<std::string>& texts, std::size_t num_classes) {
  std::vector<Rgb> palette;
  if (texts.empty()) {
    for (std::size_t i = 0; i < num_classes; ++i) palette.push_back(VocColor(i));
    return palette;
  }
  if (num_classes == 0) return palette;  // no voxel has a label
  if (texts.size() != num_classes) {
    throw UsageError("option palette has {} colors for {} classes: give one per class, or none",
                     texts.size(),
                     num_classes);
  }
  for (const std::string& text : texts) palette.push_back(ParseColor(text));
  return palette;
}

}  // namespace nightmap
