// SPDX-License-Identifier: Apache-2.0
// Locates pictures in a map of which only parts are in memory at a time.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/base/progress.h"
#include "stages/camera/localize/describe_picture.h"
#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/map_parts.h"

namespace nightmap {

struct LocatedPicture {
  QueryResult result;
  std::string problem;  // why the picture could not be used
};

// The row of a picture that could not be described or searched for.
LocatedPicture UnusedPicture(const FrameRecord& query,
                             const std::string& problem,
                             bool is_described);

// Describes the pictures, searches each in the few parts most like it, and its mirror image in the
// one most like that, and judges what all these found together. Parts much less alike than the best
// are for pictures that the others did not locate; retrieval, as in the whole map, for those that
// no part located. Loads each part once for all pictures, and once more for each of these. The
// result of a picture depends neither on the others nor on threads. Advances by two per picture.
std::vector<LocatedPicture> LocateInParts(
    const LocalizeOptions& options,
    std::span<const FrameRecord> queries,
    const std::function<DescribedPicture(const FrameRecord&)>& describe,
    const std::function<void(const char*)>& begin_part,  // as that of LocalizeInput
    MapParts& parts,
    Progress& progress,
    int num_threads);

}  // namespace nightmap
