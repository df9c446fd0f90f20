// SPDX-License-Identifier: Apache-2.0
// features/shard_NNNN.h5: keypoints, descriptors and depth of the frames of one shard.
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>
#include "pipeline/io/frames_io.h"

namespace nightmap {

enum class DescriptorKind { kRootSift, kOrb, kBrisk };

int DescriptorSize(DescriptorKind kind);  // bytes

struct FrameFeatures;

// One feature of a frame; the frame must outlive the view.
class FeatureView {
 public:
  FeatureView(const FrameFeatures& frame, int feature_idx)
      : frame_(&frame), i_(static_cast<std::size_t>(feature_idx)) {}

  Eigen::Vector2d Pixel() const;  // undistorted
  double Depth_m() const;         // 0 = not measured
  double Scale_px() const;
  const std::uint8_t* Descriptor(DescriptorKind kind) const;  // only for a described frame

 private:
  const FrameFeatures* frame_;
  std::size_t i_;
};

// Features of one image: of a described frame, strongest first, or of a tracked frame, to which the
// features of a described frame were tracked. The lists have equal length, one entry per feature.
struct FrameFeatures {
  int frame_idx = 0;
  std::vector<Eigen::Vector2f> keypoints_px;  // in the undistorted color image (same fx fy cx cy)
  std::vector<Eigen::Vector2f> raw_keypoints_px;  // as detected, in the image file
  std::vector<float> scales_px;                   // diameter of the described patch
  std::vector<float> depths_m;                    // z at the keypoint; 0 = not measured
  // num_features x descriptor_size bytes, row by row. RootSIFT has 128 bytes, 512 *
  // sqrt(l1-normalized) rounded, as COLMAP stores it (L2 distance). ORB has 32 and BRISK 64 bytes
  // (Hamming distance). A tracked frame has none.
  std::vector<std::uint8_t> descriptors;
  int reference_frame_idx = -1;         // described frame that this one was tracked from; -1: none
  std::vector<int> reference_features;  // feature of the reference frame that each entry continues;
                                        // only if tracked

  bool operator==(const FrameFeatures&) const = default;
  bool IsDescribed() const { return reference_frame_idx < 0; }
  int NumFeatures() const { return static_cast<int>(keypoints_px.size()); }
  FeatureView Feature(int feature_idx) const { return {*this, feature_idx}; }
};

inline Eigen::Vector2d FeatureView::Pixel() const {
  return frame_->keypoints_px[i_].cast<double>();
}
inline double FeatureView::Depth_m() const { return static_cast<double>(frame_->depths_m[i_]); }
inline double FeatureView::Scale_px() const { return static_cast<double>(frame_->scales_px[i_]); }
inline const std::uint8_t* FeatureView::Descriptor(DescriptorKind kind) const {
  return &frame_->descriptors[i_ * static_cast<std::size_t>(DescriptorSize(kind))];
}

struct FeaturesShard {
  DescriptorKind kind = DescriptorKind::kRootSift;
  int descriptor_size = 128;  // bytes
  std::string extraction;     // TOML of the ExtractionOptions that made them
  std::vector<FrameFeatures> frames;
};

// Features of two images that are assumed to show the same point.
struct FeatureMatch {
  int a = 0;  // feature index in the first image
  int b = 0;  // feature index in the second image

  bool operator==(const FeatureMatch&) const = default;
};

// One feature of one frame, as an observation of a point.
struct Sighting {
  int frame_idx = 0;
  int feature_idx = 0;  // index among the frame's features

  auto operator<=>(const Sighting&) const = default;
};

// The sightings of one point: ascending frame_idx, one per frame.
using Track = std::vector<Sighting>;

// `config` is the effective config that the artifact carries. They throw DataError naming
// file and field.
void WriteFeatures(const std::filesystem::path& path,
                   const FeaturesShard& shard,
                   const std::string& config);
FeaturesShard ReadFeatures(const std::filesystem::path& path);

// A shard without features: its frames have their indices only.
struct FeatureHeads {
  FeaturesShard shard;
  std::vector<int> num_features;  // by frame
};
FeatureHeads ReadFeatureHeads(const std::filesystem::path& path);

// Whether there are frames, their indices are contiguous, and each has its features at the same
// position.
bool AreOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features);
// Throws DataError unless they are.
void CheckFeaturesOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features);

}  // namespace nightmap
