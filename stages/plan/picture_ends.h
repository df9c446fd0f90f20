// SPDX-License-Identifier: Apache-2.0
// Takes the start and the goal of a path from pictures that the localize stage placed on the map.
#pragma once

#include <string>
#include <vector>

#include "pipeline/io/queries_io.h"

namespace nightmap {

// The query whose color path is `name`, or else ends with `name`, or else has it as its stem.
// Leading `..` of either are ignored, so that a picture outside the data folder is found by the
// name it was given by. Throws DataError when no query fits (naming a few that exist), when several
// fit, or when the query was not located (with its reason).
const QueryResult& FindPicture(const std::vector<QueryResult>& queries, const std::string& name);

}  // namespace nightmap
