// SPDX-License-Identifier: Apache-2.0
// features/shard_NNNN.h5: keypoints, descriptors and depth of the frames of one shard.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nightmap {

enum class DescriptorKind { kRootSift, kOrb, kBrisk };

// Features of one image: of a described frame, strongest first; or of a frame to which the features
// of a described frame were tracked. The lists have equal length, one entry a feature.
struct FrameFeatures {
  int frame_idx = 0;
  std::vector<Eigen::Vector2f> keypoints_px;  // in the undistorted color image (same fx fy cx cy)
  std::vector<Eigen::Vector2f> raw_keypoints_px;  // as detected, in the image file
  std::vector<float> scales_px;                   // diameter of the described patch
  std::vector<float> depths_m;                    // z at the keypoint; 0 = not measured
  // num_features x descriptor_size bytes, row by row. RootSIFT: 128 bytes, 512 *
  // sqrt(l1-normalized) rounded, as COLMAP stores it (L2 distance). ORB 32 and BRISK 64 bytes
  // (Hamming distance). None in a tracked frame.
  std::vector<std::uint8_t> descriptors;
  int reference_frame_idx = -1;         // the described frame this one was tracked from; -1: none
  std::vector<int> reference_features;  // its feature that each entry continues; only if tracked

  bool IsDescribed() const { return reference_frame_idx < 0; }
  int NumFeatures() const { return static_cast<int>(keypoints_px.size()); }
};

struct FeaturesShard {
  DescriptorKind kind = DescriptorKind::kRootSift;
  int descriptor_size = 128;  // bytes
  std::string extraction;     // TOML of the ExtractionOptions they were made with
  std::vector<FrameFeatures> frames;
};

// Features of two images taken to be the same point.
struct FeatureMatch {
  int a = 0;  // feature index in the first image
  int b = 0;  // in the second
};

int DescriptorSize(DescriptorKind kind);

// `config` is the effective config the artifact carries. Throw DataError naming file and field.
void WriteFeatures(const std::filesystem::path& path,
                   const FeaturesShard& shard,
                   const std::string& config);
FeaturesShard ReadFeatures(const std::filesystem::path& path);
// Shards concatenated in order; all must be of one kind.
FeaturesShard ReadFeatures(const std::vector<std::filesystem::path>& paths);

}  // namespace nightmap
