// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/inspect/sampled_pictures.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"

namespace nightmap {
namespace {

std::vector<std::string> ChannelsOfSequence(const RawSequence& sequence) {
  std::vector<std::string> channels;
  for (const RawFrame& frame : sequence.frames) {
    for (const auto& [name, file] : ChannelsOf(frame)) {
      if (!file->path.empty() && std::ranges::count(channels, name) == 0) channels.push_back(name);
    }
  }
  return channels;
}

ImageInfo InfoOf(const std::filesystem::path& path) {
  if (!SplitVideoFramePath(path) || std::filesystem::exists(path)) return InspectImage(path);
  const ColorImage frame = ReadColorImage(path);
  return {frame.width, frame.height, frame.num_channels, 8, {}};
}

}  // namespace

SampledPictures::SampledPictures(const RawSequence& sequence,
                                 const SiteConfig& site,
                                 const std::filesystem::path& data_root,
                                 int count)
    : channels_(ChannelsOfSequence(sequence)) {
  const std::size_t num_frames = sequence.frames.size();
  num_sampled_ = std::min(num_frames, static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < num_sampled_; ++i) {
    Look(sequence.frames[i * num_frames / num_sampled_], site, data_root);
  }
}

void SampledPictures::Look(const RawFrame& frame,
                           const SiteConfig& site,
                           const std::filesystem::path& data_root) {
  for (const auto& [name, file] : ChannelsOf(frame)) {
    if (file->path.empty()) continue;
    try {
      const ImageInfo info = InfoOf(data_root / file->path);
      kinds_[name].insert(fmt::format(
          "{} x {}, {} of {} bits", info.width, info.height, info.num_channels, info.num_bits));
      if (name == "depth" && frame.camera_idx >= 0) {
        LookAtDepth(frame, site.cameras.at(static_cast<std::size_t>(frame.camera_idx)), data_root);
      }
    } catch (const DataError&) {
      ++num_unreadable_[name];
    }
  }
}

void SampledPictures::LookAtDepth(const RawFrame& frame,
                                  const RgbdCamera& camera,
                                  const std::filesystem::path& data_root) {
  for (const float depth_m : LoadDepth(frame, camera, data_root).pixels) {
    ++num_pixels_;
    if (depth_m <= 0) continue;
    min_depth_m_ = num_measured_ == 0 ? depth_m : std::min(min_depth_m_, depth_m);
    max_depth_m_ = std::max(max_depth_m_, depth_m);
    ++num_measured_;
  }
}

std::string SampledPictures::Describe(const std::string& channel) const {
  std::string text;
  if (const auto kinds = kinds_.find(channel); kinds != kinds_.end()) {
    text = fmt::format("{}", fmt::join(kinds->second, "; "));
  }
  if (channel == "depth" && num_measured_ > 0) {
    text +=
        fmt::format(", {:.2f} to {:.2f} m, {:.0f} % measured",
                    min_depth_m_,
                    max_depth_m_,
                    100.0 * static_cast<double>(num_measured_) / static_cast<double>(num_pixels_));
  }
  if (const auto count = num_unreadable_.find(channel); count != num_unreadable_.end()) {
    text += fmt::format("{}{} of {} looked at cannot be read",
                        text.empty() ? "" : ", ",
                        count->second,
                        num_sampled_);
  }
  return text;
}

}  // namespace nightmap
