// SPDX-License-Identifier: Apache-2.0
// Extracts the features of a query picture.
#pragma once

#include <string>

#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/picture_pose.h"

namespace nightmap {

// Options of the features in the map, by which those of pictures are extracted, too. `source` names
// the map in messages.
ExtractionOptions ExtractionOf(const LandmarkMap& map, const std::string& source);

// The features of a picture, or the reason why it has none.
struct DescribedPicture {
  FrameFeatures features;
  PictureLens lens;     // of the picture as described, scaled down where it was too fine
  std::string problem;  // empty: no problem
};

// Does not throw for a picture that cannot be read, that OpenCV cannot process, or that does not
// fit into memory; returns the problem instead.
DescribedPicture DescribePicture(const LocalizeOptions& options,
                                 const LocalizeInput& input,
                                 const FrameRecord& query);

}  // namespace nightmap
