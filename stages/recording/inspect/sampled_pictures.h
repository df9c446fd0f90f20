// SPDX-License-Identifier: Apache-2.0
// Sample frames of a recording, to describe its pictures.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

class SampledPictures {
 public:
  // Reads `count` evenly spaced frames of the recording.
  SampledPictures(const RawSequence& sequence,
                  const SiteConfig& site,
                  const std::filesystem::path& data_root,
                  int count);

  // The channels that frames of the recording have: color first, then depth.
  const std::vector<std::string>& Channels() const { return channels_; }
  // "640 x 480, 3 of 8 bits" for each kind of picture; for depth also its range and the share
  // measured.
  std::string Describe(const std::string& channel) const;

 private:
  void Look(const RawFrame& frame, const SiteConfig& site, const std::filesystem::path& data_root);
  void LookAtDepth(const RawFrame& frame,
                   const RgbdCamera& camera,
                   const std::filesystem::path& data_root);

  std::vector<std::string> channels_;
  std::map<std::string, std::set<std::string>> kinds_;  // by channel
  std::map<std::string, std::size_t> num_unreadable_;
  std::size_t num_sampled_ = 0;
  float min_depth_m_ = 0;
  float max_depth_m_ = 0;
  std::size_t num_pixels_ = 0;
  std::size_t num_measured_ = 0;
};

}  // namespace nightmap
