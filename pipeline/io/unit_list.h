// SPDX-License-Identifier: Apache-2.0
// frames/shards.txt and tiles/tiles.txt: which shards or tiles there are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

// A line `nightmap <kind>, version 1, <n> names`, then a name per line. The count tells a whole
// list from one that was cut off. scripts/nightmap_eval/unit_lists.py reads it, as data.
std::string NameListToText(std::string_view kind, const std::vector<std::string>& names);

}  // namespace nightmap
