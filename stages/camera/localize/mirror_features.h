// SPDX-License-Identifier: Apache-2.0
// The features that a picture would have, were it mirrored.
#pragma once

#include <optional>

#include "pipeline/geometry/camera.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

// Mirrors left and right about the principal point: each keypoint keeps its index, and a RootSIFT
// descriptor its values in another order (the symmetry behind MIFT, a mirror reflection invariant
// feature descriptor, Guo et al., ACCV 2009). The lens then is the same, mirrored; if its principal
// point is off the middle of the picture, the camera's pose turns by as much. Returns nothing for
// other descriptors, which have no such order.
std::optional<FrameFeatures> MirrorFeatures(const FrameFeatures& features,
                                            DescriptorKind kind,
                                            const Camera& camera);

}  // namespace nightmap
