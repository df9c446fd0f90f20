// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/depth_alignment.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nightmap {
namespace {

constexpr float kMinStep = 0.08F;  // of the depth, relative: sensors blur less
constexpr int kShiftStep_px = 2;
constexpr int kMaxShiftX_px = 24;
constexpr int kMaxShiftY_px = 14;

float DepthUnder(const DepthImage& depth, const GrayImage& small, int x, int y) {
  return depth.At(std::min(depth.width - 1, (2 * x + 1) * depth.width / (2 * small.width)),
                  std::min(depth.height - 1, (2 * y + 1) * depth.height / (2 * small.height)));
}

// The sum of the strengths at the edges, shifted; and how many of them lie in the picture.
struct Sum {
  double strength = 0;
  std::size_t count = 0;
  void Add(const FrameEdges& color, const FrameEdges& depth, int shift_x, int shift_y) {
    const Image<float>& strengths = color.strengths;
    for (const Pixel& pixel : depth.at) {
      const int x = pixel.x + shift_x, y = pixel.y + shift_y;
      if (x < 0 || y < 0 || x >= strengths.width || y >= strengths.height) continue;
      strength += strengths.At(x, y);
      ++count;
    }
  }
  double Mean() const { return count == 0 ? 0 : strength / static_cast<double>(count); }
};

// All offsets look at the same depth pictures, so that their contents do not matter.
void MeasureFrameOffsets(const std::vector<FrameEdges>& frames, DepthAlignment* alignment) {
  const int num_frames = static_cast<int>(frames.size());
  for (int offset = -kMaxFrameOffset; offset <= kMaxFrameOffset; ++offset) {
    Sum sum;
    for (int i = kMaxFrameOffset; i < num_frames - kMaxFrameOffset; ++i) {
      sum.Add(
          frames[static_cast<std::size_t>(i + offset)], frames[static_cast<std::size_t>(i)], 0, 0);
    }
    alignment->by_frame_offset[static_cast<std::size_t>(offset + kMaxFrameOffset)] = sum.Mean();
  }
}

std::vector<Pixel> MakeShifts() {
  std::vector<Pixel> shifts;
  for (int y = -kMaxShiftY_px; y <= kMaxShiftY_px; y += kShiftStep_px) {
    for (int x = -kMaxShiftX_px; x <= kMaxShiftX_px; x += kShiftStep_px) shifts.push_back({x, y});
  }
  return shifts;
}

void MeasureShifts(const std::vector<FrameEdges>& frames, DepthAlignment* alignment) {
  for (const Pixel& shift : Shifts()) {
    Sum sum;
    for (const FrameEdges& frame : frames) sum.Add(frame, frame, shift.x, shift.y);
    alignment->by_shift.push_back(sum.Mean());
  }
}

}  // namespace

const std::vector<Pixel>& Shifts() {
  static const std::vector<Pixel> shifts = MakeShifts();
  return shifts;
}

BestShift FindBestShift(const std::vector<DepthAlignment>& windows) {
  BestShift best;
  std::size_t best_at = 0, zero_at = 0;
  double most = -1;
  for (std::size_t i = 0; i < Shifts().size(); ++i) {
    double sum = 0;
    for (const DepthAlignment& window : windows) {
      sum += static_cast<double>(window.num_edges) * window.by_shift.at(i);
    }
    if (Shifts()[i].x == 0 && Shifts()[i].y == 0) zero_at = i;
    if (sum <= most) continue;
    most = sum;
    best_at = i;
  }
  best.shift = Shifts()[best_at];
  for (const DepthAlignment& window : windows) {
    best.at_best.push_back(window.by_shift[best_at]);
    best.at_zero.push_back(window.by_shift[zero_at]);
  }
  return best;
}

FrameEdges EdgesOf(const GrayImage& small, const DepthImage& depth) {
  FrameEdges edges;
  edges.strengths = {small.width, small.height, 1, std::vector<float>(small.pixels.size())};
  const cv::Mat gray(
      small.height, small.width, CV_8UC1, const_cast<std::uint8_t*>(small.pixels.data()));
  cv::Mat smooth, x, y, strengths(small.height, small.width, CV_32F, edges.strengths.pixels.data());
  cv::GaussianBlur(gray, smooth, {0, 0}, 1.0);
  cv::Sobel(smooth, x, CV_32F, 1, 0);
  cv::Sobel(smooth, y, CV_32F, 0, 1);
  cv::magnitude(x, y, strengths);
  strengths /= std::max(1e-6, cv::mean(strengths)[0]);
  if (depth.pixels.empty()) return edges;
  std::vector<Pixel> all;
  for (int row = 1; row + 1 < small.height; ++row) {
    for (int column = 1; column + 1 < small.width; ++column) {
      const float here = DepthUnder(depth, small, column, row);
      if (here <= 0) continue;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (DepthUnder(depth, small, column + dx, row + dy) > (1 + kMinStep) * here) {
          all.push_back({column, row});
          break;
        }
      }
    }
  }
  const std::size_t count = std::min(all.size(), kMaxEdgePixels);
  for (std::size_t i = 0; i < count; ++i) edges.at.push_back(all[i * all.size() / count]);
  return edges;
}

DepthAlignment MeasureAlignment(const std::vector<FrameEdges>& frames) {
  DepthAlignment alignment;
  for (const FrameEdges& frame : frames) alignment.num_edges += frame.at.size();
  if (alignment.num_edges == 0) return alignment;
  MeasureFrameOffsets(frames, &alignment);
  MeasureShifts(frames, &alignment);
  return alignment;
}

}  // namespace nightmap
