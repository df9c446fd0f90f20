// SPDX-License-Identifier: Apache-2.0
// Keypoints and descriptors of one image: RootSIFT (Arandjelovic and Zisserman, CVPR 2012), ORB
// (Rublee et al., ICCV 2011), BRISK (Leutenegger et al., ICCV 2011), FAST corners (Rosten and
// Drummond, ECCV 2006) with the descriptors of ORB or BRISK, and Harris corners (harris_corners.h)
// with those of ORB. SURF is not available, because it is patented and Debian's OpenCV is built
// without it.
#pragma once

#include <string>

#include "pipeline/base/options.h"
#include "pipeline/camera/harris_corners.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

struct ExtractionOptions {
  std::string detector = "sift";
  int num_features = 1000;  // the strongest are kept
  double sift_contrast_threshold = 0.02;
  double sift_edge_threshold = 10.0;
  int sift_num_octave_layers = 3;
  int fast_threshold = 10;  // ORB, BRISK and FAST
  HarrisOptions harris;
  int depth_window_px = 2;       // half size of the window for depth lookup
  double max_depth_step = 0.05;  // relative depth difference that counts as an edge

  void Register(OptionList& list);
  DescriptorKind Kind() const;
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
