// SPDX-License-Identifier: Apache-2.0
// The start and the goal of a path may be pictures that the localize stage placed on the map.
#pragma once

#include <string>
#include <vector>

#include "pipeline/io/queries_io.h"

namespace nightmap {

// The query whose color path is `name`, or else ends with it (leading `..` of either left out, so
// that a picture outside the data folder has the name it was given by), or else has it as its stem.
// Throws DataError when there is none (naming a few that there are), when several fit, or when it
// was not located (with its reason).
const QueryResult& FindPicture(const std::vector<QueryResult>& queries, const std::string& name);

}  // namespace nightmap
