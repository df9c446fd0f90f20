// SPDX-License-Identifier: Apache-2.0
// Putative matches between the descriptors of two images.
#pragma once

#include <vector>

#include "pipeline/io/features_io.h"

namespace nightmap {

// Exhaustive nearest neighbours with Lowe's ratio test (IJCV 2004) and mutual check. Sorted by `a`.
// Deterministic; one thread. L2 for RootSIFT, Hamming for ORB and BRISK.
std::vector<FeatureMatch> MatchDescriptors(const FrameFeatures& a,
                                           const FrameFeatures& b,
                                           DescriptorKind kind,
                                           double max_ratio);

}  // namespace nightmap
