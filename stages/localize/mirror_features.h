// SPDX-License-Identifier: Apache-2.0
// The features that a picture would have, were it mirrored.
#pragma once

#include <optional>

#include "pipeline/geometry/camera.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

// Mirrors left and right about the principal point: each keypoint keeps its index, and a RootSIFT
// descriptor its values in another order (as MI-SIFT uses, Ma et al., ICIP 2010). The lens then is
// the same, mirrored; if its principal point is off the middle of the picture, the camera's pose
// turns by as much. Returns nothing for other descriptors, whose patterns have no symmetry.
std::optional<FrameFeatures> MirrorFeatures(const FrameFeatures& features,
                                            DescriptorKind kind,
                                            const Camera& camera);

}  // namespace nightmap
