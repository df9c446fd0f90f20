// SPDX-License-Identifier: Apache-2.0
// What the comparisons work on: a recording and the map that was made of it.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "pipeline/io/landmarks_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/dense/rgbd_keyframes.h"

namespace nightmap {

struct MappedSite {
  std::string name;
  std::filesystem::path data;
  std::vector<FrameRecord> frames;
  std::vector<RgbdCamera> cameras;
  FeaturesShard features;          // of the frames, in their order
  std::vector<FramePair> loops;    // accepted, of described frames
  std::vector<StampedPose> truth;  // world_from_camera, of the frames that have one
  LandmarkMap landmarks;
  KeyframeSource keyframes;

  const RgbdCamera& CameraOf(int frame_idx) const {
    const int camera_idx = frames[static_cast<std::size_t>(frame_idx)].camera_idx;
    return cameras[static_cast<std::size_t>(camera_idx)];
  }
  const FrameFeatures& FeaturesOf(int frame_idx) const {
    return features.frames[static_cast<std::size_t>(frame_idx)];
  }
};

// `site` is MAPS/SITE after `make map`, with RootSIFT features. Throws DataError when it is not.
MappedSite ReadMappedSite(const std::filesystem::path& site, const std::filesystem::path& data);

// At most `count` of a list, evenly spaced.
template <typename Item>
std::vector<Item> EvenlySpaced(const std::vector<Item>& items, std::size_t count) {
  if (items.size() <= count) return items;
  std::vector<Item> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(items[i * items.size() / count]);
  return chosen;
}

}  // namespace nightmap
