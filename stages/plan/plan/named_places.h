// SPDX-License-Identifier: Apache-2.0
// Finds the places that ends of a path are named after: pictures and laser scans that were located
// on the map, its objects and its things.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/io/queries_io.h"
#include "pipeline/io/things_io.h"
#include "pipeline/plan/objects_io.h"
#include "stages/plan/plan/end_box.h"

namespace nightmap {

// The query whose path is `name`, or else ends with `name`, or else has it as its stem.
// Leading `..` of either are ignored, so that a file outside the data folder is found by the name
// it was given by. `kind` is "picture" or "scan", for messages. Throws DataError when no query fits
// (naming a few that exist), when several fit, or when the query was not located (with its reason).
const QueryResult& FindQuery(const std::vector<QueryResult>& queries,
                             const std::string& kind,
                             const std::string& name);

struct NamedBox {
  EndBox box;
  std::string class_name;          // of a thing
  std::optional<double> bottom_m;  // z of a thing's lower face
};

// The object of this name, or else the thing of this name, or else all things of the class of this
// name. Throws DataError naming those objects, things and classes that are spelt most alike.
std::vector<NamedBox> FindBoxes(const std::vector<MapObject>& objects,
                                const std::vector<Thing>& things,
                                const std::string& name);

// The first few, separated by commas.
std::string FewNames(const std::vector<std::string>& names);

}  // namespace nightmap
