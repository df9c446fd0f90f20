// SPDX-License-Identifier: Apache-2.0
// frames/shards.txt and tiles/tiles.txt: lists of the shards and of the tiles.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

// A line `nightmap <kind>, version 1, <n> names`, then one name per line. The count shows whether
// the list is complete. scripts/nightmap_site/unit_lists.py also reads it.
std::string NameListToText(std::string_view kind, const std::vector<std::string>& names);

}  // namespace nightmap
