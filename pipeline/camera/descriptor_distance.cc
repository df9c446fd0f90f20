// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/descriptor_distance.h"

namespace nightmap {

int DistanceFromRelative(DescriptorKind kind, double relative) {
  if (kind == DescriptorKind::kRootSift) {
    const double distance = relative * 512.0;  // the norm of a stored RootSIFT
    return static_cast<int>(distance * distance);
  }
  return static_cast<int>(relative * 4.0 * DescriptorSize(kind));
}

bool PassesRatioTest(DescriptorKind kind, int best, int second, double max_ratio) {
  const double ratio = kind == DescriptorKind::kRootSift ? max_ratio * max_ratio : max_ratio;
  return static_cast<double>(best) < ratio * static_cast<double>(second);
}

}  // namespace nightmap
