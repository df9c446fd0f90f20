// SPDX-License-Identifier: Apache-2.0
// Texts that people and file systems give, as CSV, JSON, messages and a terminal can hold them.
#pragma once

#include <string>
#include <string_view>

namespace nightmap {

// Whether the text is UTF-8 without control characters (of ASCII and U+0080 to U+009F, which some
// terminals obey). File systems allow any bytes in a name.
bool IsText(std::string_view text);
// The text itself if it is one; otherwise with everything but printable ASCII written as \xNN.
std::string AsText(std::string_view text);
// A message of several lines, each as AsText writes it.
std::string AsLines(std::string_view message);

}  // namespace nightmap
