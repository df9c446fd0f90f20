// SPDX-License-Identifier: Apache-2.0
// Keypoints and descriptors of one image: RootSIFT (Arandjelovic and Zisserman, CVPR 2012), ORB
// (Rublee et al., ICCV 2011), BRISK (Leutenegger et al., ICCV 2011), FAST corners (Rosten and
// Drummond, ECCV 2006) with the descriptors of ORB or BRISK, and Harris corners (harris_corners.h)
// with those of ORB. SURF is not available, because it is patented and Debian's OpenCV is built
// without it.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/camera/harris_corners.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

std::vector<std::string> DetectorNames();

struct ExtractionOptions {
  OPTION(std::string, detector, "sift", DetectorNames(),
         "keypoints and descriptors; fast_: FAST corners of one scale, described upright; harris: "
         "Harris corners of one scale, described as by ORB at any angle. SURF is missing because "
         "it is patented and Debian's OpenCV is built without it");
  OPTION(int, num_features, 1000, {50, 20000},
         "number of features kept per image, strongest first");
  double sift_contrast_threshold = 0.02;  // lower finds more features on weak texture
  OPTION(int, fast_threshold, 10, {1, 100}, "threshold of ORB, BRISK and FAST, in gray levels");
  HarrisOptions harris;

  DescriptorKind Kind() const;
  REGISTER_OPTIONS();
};

// Features of a color image without depth (depths_m all 0). Deterministic; one thread. Keypoints
// are undistorted with `camera` and sorted by response (strongest first, ties by position). None
// lies in `moving`, a mask of the picture's size; those elsewhere fill the number. Where a mask
// leaves fewer than 300, keypoints of a third of the contrast are taken, too, up to that number.
FrameFeatures ExtractFeatures(const ColorImage& color,
                              const Camera& camera,
                              const ExtractionOptions& options,
                              const GrayImage& moving = {});

}  // namespace nightmap
