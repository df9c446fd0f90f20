// SPDX-License-Identifier: Apache-2.0
// Images as plain arrays. Videos, and pictures but PNG, JPEG and PGM, are read through media.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/exif_lens.h"

namespace nightmap {

template <typename T>
struct Image {
  int width = 0;
  int height = 0;
  int num_channels = 1;
  std::vector<T> pixels;  // row by row, channels interleaved

  T& At(int x, int y, int channel = 0) {
    return pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(x)) *
                      static_cast<std::size_t>(num_channels) +
                  static_cast<std::size_t>(channel)];
  }
  const T& At(int x, int y, int channel = 0) const {
    return const_cast<Image*>(this)->At(x, y, channel);
  }
};

using ColorImage = Image<std::uint8_t>;  // 3 channels, RGB
using GrayImage = Image<std::uint8_t>;   // 1 channel
using LabelImage = Image<std::uint8_t>;  // 1 channel
using RawDepthImage = Image<std::uint16_t>;
using DepthImage = Image<float>;  // metres along z; 0 = no measurement

// `path` is an image file, or `clip.avi#N` for frame N (from 0) of a video. Expands gray input to
// RGB and drops alpha. Pixels are as stored: the whole program ignores EXIF's Orientation, by which
// viewers rotate a picture. Throws DataError naming the file when it is missing, truncated or not
// an image.
ColorImage ReadColorImage(const std::filesystem::path& path);
GrayImage ToGray(const ColorImage& image);

// All channels of a picture, 1 to 4, alpha the last of 2 or 4; values of fewer bits scaled to 16,
// colors of a palette in place of its indices. Throws DataError naming the file.
Image<std::uint16_t> ReadChannels(const std::filesystem::path& path);

// 16-bit single-channel depth as stored. Throws DataError naming the file.
RawDepthImage ReadRawDepth(const std::filesystem::path& path);

// The header of an image file. Cheap: decodes no pixels.
struct ImageInfo {
  int width = 0;
  int height = 0;
  int num_channels = 0;
  int num_bits = 0;  // per channel
  ExifLens lens;
  bool is_float = false;  // the values are floating-point numbers
};
// Throws DataError naming the file when it is missing, empty, not an image, or (PNG, JPEG) lacks
// its end mark, as after an interrupted copy.
ImageInfo InspectImage(const std::filesystem::path& path);

// Properties of a video, whose pixels are as stored: a rotation for the display turns neither them
// nor width and height. Frames are counted by reading through the file, since headers only estimate
// their number.
struct VideoInfo {
  int width = 0;
  int height = 0;
  int num_frames = 0;
  double frame_rate_hz = 0;            // as the header says
  std::vector<std::int64_t> times_ns;  // of each frame, as the container says; from 0
};
VideoInfo InspectVideo(const std::filesystem::path& path);
// Number of video frames that this process has decoded, whether returned or passed over; for tests.
std::int64_t NumDecodedVideoFrames();
// Builds and splits `clip.avi#N`. Nothing when the path does not end in `#N`.
std::filesystem::path VideoFramePath(const std::filesystem::path& video, int frame_idx);
std::optional<std::pair<std::filesystem::path, int>> SplitVideoFramePath(
    const std::filesystem::path& path);

// Reads labels or a mask: the values as stored. Those of a PNG of 1, 2 or 4 bits, or of a palette,
// are indices, which no color of a palette replaces. Throws DataError naming the file when it has
// more than one channel, more than 8 bits or is no PNG.
LabelImage ReadLabelImage(const std::filesystem::path& path);
// As InspectImage, of what ReadLabelImage reads: one channel of 8 bits.
ImageInfo InspectLabelImage(const std::filesystem::path& path);

// Writes 8-bit (1 or 3 channels) and 16-bit PNG with fixed compression and no metadata: equal
// pixels give equal bytes. Throws DataError.
void WritePng(const std::filesystem::path& path, const Image<std::uint8_t>& image);
void WritePng(const std::filesystem::path& path, const Image<std::uint16_t>& image);

}  // namespace nightmap
