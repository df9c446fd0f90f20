// SPDX-License-Identifier: Apache-2.0
// Texts of people in YAML: quoted so that YAML 1.1 and 1.2 read the same, and checked to be UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace nightmap {

// A double-quoted scalar. Escapes what YAML does not print: controls, the line breaks of Unicode,
// byte order marks. Throws DataError when the text is not UTF-8.
std::string QuotedForYaml(std::string_view text);

// Throws DataError naming file and line when the text is not UTF-8, which YAML libraries repair.
void CheckUtf8(const std::string& source, std::string_view text);

}  // namespace nightmap
