// SPDX-License-Identifier: Apache-2.0
// The sparse 3-D map that pictures are localized against, and a region of it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/geometry/rectangle.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

struct MapKeyframe {
  int frame_idx = 0;
  std::int64_t time_ns = 0;
  Rigid3 map_from_camera;
};

struct LandmarkMap {
  DescriptorKind kind = DescriptorKind::kRootSift;
  std::string extraction;  // TOML of the ExtractionOptions; queries must use the same
  std::vector<Eigen::Vector3d> positions_in_map;
  std::vector<float> position_sigmas_m;
  std::vector<std::uint8_t> descriptors;  // row by row
  std::vector<int> descriptor_landmarks;  // landmark of each descriptor, ascending
  int num_word_levels = 1;
  std::vector<int> words;  // num_word_levels per descriptor; the leaf is repeated
  std::vector<MapKeyframe> keyframes;
  std::vector<std::vector<int>> landmark_keyframes;  // keyframes that see each landmark, ascending
  // Feature of each of these keyframes that shows it.
  std::vector<std::vector<int>> landmark_features;

  int NumLandmarks() const { return static_cast<int>(positions_in_map.size()); }
  int NumDescriptors() const { return static_cast<int>(descriptor_landmarks.size()); }
  const std::uint8_t* Descriptor(int i) const {
    return &descriptors[static_cast<std::size_t>(i) *
                        static_cast<std::size_t>(DescriptorSize(kind))];
  }
  // Vocabulary node of a descriptor at a level (1 is just below the root).
  int Word(int descriptor, int level) const {
    return words[static_cast<std::size_t>(descriptor) * static_cast<std::size_t>(num_word_levels) +
                 static_cast<std::size_t>(level - 1)];
  }
  // The transpose of landmark_keyframes.
  std::vector<std::vector<int>> KeyframeLandmarks() const;
  // Index of each landmark's first descriptor, then the number of descriptors.
  std::vector<int> DescriptorOffsets() const;
};

// A part of the map that lies in one rectangle of the plane.
struct LandmarkRegion {
  Rectangle box;  // holds the positions of its landmarks
  std::int64_t num_landmarks = 0;
  std::vector<int> keyframes;  // that see at least one of them, ascending
};

// Adds the landmarks of a region behind those of the map. Both have the same kind, levels and
// keyframes.
void AppendLandmarks(LandmarkMap region, LandmarkMap* map);

}  // namespace nightmap
