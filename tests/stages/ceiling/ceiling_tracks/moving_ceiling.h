// SPDX-License-Identifier: Apache-2.0
// Pictures of a ceiling of gray tiles that turns and moves below the camera, and where each point
// of it is in each picture.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/camera/extract_features.h"
#include "stages/ceiling/ceiling_tracks/ceiling_tracks.h"

namespace nightmap {

struct MovingCeiling {
  static constexpr int kWidth = 320, kHeight = 240;
  Camera camera{kWidth, kHeight, 250, 250, 159.5, 119.5};
  double angle_rad = 0.3;              // of frame 0: its tiles lie at all phases to the pixels
  double turn_rad = 0.01;              // per frame
  Eigen::Vector2d step_px{2.3, -1.1};  // per frame

  Eigen::Vector2d PixelOf(const Eigen::Vector2d& point, int frame) const {
    return Eigen::Rotation2Dd(angle_rad + turn_rad * frame) * point + frame * step_px +
           Eigen::Vector2d(160, 120);
  }
  Eigen::Vector2d PointAt(const Eigen::Vector2d& pixel, int frame) const {
    return Eigen::Rotation2Dd(-angle_rad - turn_rad * frame) *
           (pixel - frame * step_px - Eigen::Vector2d(160, 120));
  }

  // A pixel is the mean of 6 x 6 points.
  GrayImage Picture(int frame) const {
    GrayImage image{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
    Random random(11);
    std::vector<double> grays;
    for (int i = 0; i < 64 * 64; ++i) grays.push_back(random.Uniform(30, 225));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        double sum = 0;
        for (int k = 0; k < 36; ++k) {
          const Eigen::Vector2d part((k % 6) / 6.0 - 5 / 12.0, (k / 6) / 6.0 - 5 / 12.0);
          const Eigen::Vector2d tile = PointAt(Eigen::Vector2d(x, y) + part, frame) / 17;
          const int column = std::clamp(static_cast<int>(std::floor(tile.x())) + 32, 0, 63);
          const int row = std::clamp(static_cast<int>(std::floor(tile.y())) + 32, 0, 63);
          sum += grays[static_cast<std::size_t>(64 * row + column)];
        }
        image.At(x, y) = static_cast<std::uint8_t>(std::lround(sum / 36));
      }
    }
    return image;
  }
};

// Input of frames first, first + 1 ... with these pictures. One without pixels cannot be read.
inline CeilingTracksInput InputOf(const MovingCeiling& ceiling,
                                  const std::vector<GrayImage>& pictures,
                                  int first) {
  ExtractionOptions extraction;
  extraction.detector = "harris";
  extraction.num_features = 300;
  CeilingTracksInput input;
  input.cameras.push_back({});
  input.cameras[0].color = ceiling.camera;
  input.features.kind = DescriptorKind::kOrb;
  input.features.descriptor_size = 32;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const int frame_idx = first + static_cast<int>(i);
    const std::string name = std::to_string(frame_idx);
    input.frames.push_back({frame_idx, 1000 + 100 * frame_idx, 0, 0, {name, "h"}, {}, {}});
    FrameFeatures features;
    if (!pictures[i].pixels.empty()) {
      ColorImage color{pictures[i].width, pictures[i].height, 3, {}};
      for (const auto value : pictures[i].pixels) {
        color.pixels.insert(color.pixels.end(), 3, value);
      }
      features = ExtractFeatures(color, ceiling.camera, extraction);
    }
    features.frame_idx = frame_idx;
    input.features.frames.push_back(features);
  }
  input.load = [pictures, first](const FrameRecord& frame) {
    const GrayImage& picture = pictures[static_cast<std::size_t>(frame.frame_idx - first)];
    if (picture.pixels.empty()) throw DataError("{}: truncated", frame.color.path);
    return picture;
  };
  return input;
}

}  // namespace nightmap
