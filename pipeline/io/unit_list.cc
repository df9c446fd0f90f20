// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/unit_list.h"

#include <fmt/format.h>

namespace nightmap {

std::string NameListToText(std::string_view kind, const std::vector<std::string>& names) {
  std::string text = fmt::format("nightmap {}, version 1, {} names\n", kind, names.size());
  for (const std::string& name : names) text += name + '\n';
  return text;
}

}  // namespace nightmap
