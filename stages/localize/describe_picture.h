// SPDX-License-Identifier: Apache-2.0
// From a query's pixels to its features.
#pragma once

#include <string>

#include "stages/localize/localize.h"

namespace nightmap {

// What is known of a picture before it is searched for: its features, or why it has none.
struct DescribedPicture {
  FrameFeatures features;
  Camera camera;        // of the picture as it was described: scaled down, where it was too fine
  std::string problem;  // empty: there is none
};

// Throws nothing for a picture that cannot be read, or that OpenCV cannot cope with, or that
// does not fit into memory: it has a problem.
DescribedPicture DescribePicture(const LocalizeOptions& options,
                                 const LocalizeInput& input,
                                 const FrameRecord& query);

}  // namespace nightmap
