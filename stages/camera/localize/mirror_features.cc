// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/mirror_features.h"

#include <cstddef>

namespace nightmap {
namespace {

// RootSIFT: 4 rows of 4 cells of 8 gradient directions, in a frame whose x axis is the keypoint's
// direction. Mirroring turns rows and directions over that axis.
constexpr std::size_t kCells = 4;
constexpr std::size_t kDirections = 8;
constexpr std::size_t kSize = kCells * kCells * kDirections;

void MirrorDescriptor(const std::uint8_t* from, std::uint8_t* to) {
  for (std::size_t row = 0; row < kCells; ++row) {
    for (std::size_t column = 0; column < kCells; ++column) {
      const std::size_t source = ((kCells - 1 - row) * kCells + column) * kDirections;
      const std::size_t target = (row * kCells + column) * kDirections;
      for (std::size_t i = 0; i < kDirections; ++i) {
        to[target + i] = from[source + (kDirections - i) % kDirections];
      }
    }
  }
}

}  // namespace

std::optional<FrameFeatures> MirrorFeatures(const FrameFeatures& features,
                                            DescriptorKind kind,
                                            const Camera& camera) {
  if (kind != DescriptorKind::kRootSift) return {};
  FrameFeatures mirrored = features;
  for (auto& keypoint : mirrored.keypoints_px) {
    keypoint.x() = static_cast<float>(2 * camera.cx) - keypoint.x();
  }
  for (std::size_t i = 0; i < features.descriptors.size(); i += kSize) {
    MirrorDescriptor(&features.descriptors[i], &mirrored.descriptors[i]);
  }
  return mirrored;
}

}  // namespace nightmap
