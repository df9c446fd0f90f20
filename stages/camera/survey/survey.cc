// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/survey.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/resize_picture.h"

namespace nightmap {
namespace {

// Consecutive frames per window: more show more of the order of frames.
constexpr int kWindowFrames = 20;

// Consecutive frames: [begin, end) are measured, and the frame before `begin` is read too.
struct Window {
  std::size_t begin = 0;
  std::size_t end = 0;
};

struct WindowResult {
  std::vector<SurveyedFrame> frames;
  std::vector<GrayImage> reduced;  // of the frames
  DepthAlignment alignment;
  std::vector<std::string> skipped;
};

std::vector<Window> ChooseWindows(const SurveyOptions& options, std::size_t num_frames) {
  const auto length = static_cast<std::size_t>(kWindowFrames);
  const std::size_t num_wanted =
      std::max<std::size_t>(1, static_cast<std::size_t>(options.max_frames) / length);
  const std::size_t num_whole = (num_frames + length - 1) / length;
  const std::size_t count = std::min(num_wanted, num_whole);
  std::vector<Window> windows;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = i * num_whole / count * length;
    windows.push_back({begin, std::min(num_frames, begin + length)});
  }
  return windows;
}

// A frame that the next one is compared with.
struct Seen {
  const FrameRecord* frame = nullptr;
  GrayImage small;
  DepthImage depth;
};

bool IsMeasured(float depth_m) { return depth_m > 0; }

// Compares pixels: all frames of a video have the hash of its file, and all pictures without depth
// are alike.
PairMeasures Compare(const Seen& previous, const Seen& current) {
  const bool belongs = previous.frame != nullptr &&
                       previous.frame->camera_idx == current.frame->camera_idx &&
                       previous.frame->sequence_idx == current.frame->sequence_idx;
  if (!belongs) return {};
  PairMeasures measures = MeasurePair(previous.small, current.small);
  measures.same_depth = previous.depth.pixels == current.depth.pixels &&
                        std::ranges::any_of(current.depth.pixels, IsMeasured);
  return measures;
}

GrayImage Small(const ColorImage& color, const RgbdCamera& camera) {
  const double scale = std::min(1.0, kSmallWidth_px / color.width);
  return ToGray(ShrinkPicture(color, camera.color, scale).color);
}

WindowResult Measure(const SurveyInput& input, const Window& window, Progress& progress) {
  WindowResult result;
  std::vector<FrameEdges> edges;
  Seen previous;
  for (std::size_t i = window.begin == 0 ? 0 : window.begin - 1; i < window.end; ++i) {
    const FrameRecord& frame = input.frames[i];
    const std::string failure = FrameFailure(frame.color.path, [&] {
      RgbdImages images = input.load(frame);
      const RgbdCamera& camera = input.cameras.at(static_cast<std::size_t>(frame.camera_idx));
      Seen current{&frame, Small(images.color, camera), std::move(images.depth)};
      if (i >= window.begin) {
        result.frames.push_back({i,
                                 MeasureFrame(ToGray(images.color), current.small, current.depth),
                                 Compare(previous, current)});
        result.frames.back().own.planar = MeasurePlanarShares(
            current.depth, camera.color, camera.depth_along_ray, static_cast<std::uint64_t>(i));
        const bool fits = edges.empty() || edges.front().strengths.width == current.small.width;
        if (fits) edges.push_back(EdgesOf(current.small, current.depth));
        result.reduced.push_back(current.small);
      }
      previous = std::move(current);
    });
    if (!failure.empty()) previous = {};
    if (i < window.begin) continue;
    if (!failure.empty()) result.skipped.push_back(failure);
    progress.Advance();
  }
  result.alignment = MeasureAlignment(edges);
  result.alignment.first_frame = window.begin;
  return result;
}

// Per camera, of the reduced pictures of all its frames.
std::vector<FixedParts> FindFixedParts(const SurveyInput& input,
                                       std::vector<WindowResult>& windows) {
  std::vector<std::vector<GrayImage>> pictures(input.cameras.size());
  for (WindowResult& window : windows) {
    for (std::size_t i = 0; i < window.frames.size(); ++i) {
      const FrameRecord& frame = input.frames[window.frames[i].frame];
      pictures[static_cast<std::size_t>(frame.camera_idx)].push_back(std::move(window.reduced[i]));
    }
  }
  std::vector<FixedParts> parts;
  for (const auto& of_camera : pictures) parts.push_back(FindFixedParts(of_camera));
  return parts;
}

}  // namespace

SurveyResult RunSurvey(const SurveyOptions& options,
                       const SurveyInput& input,
                       Progress& progress,
                       int num_threads) {
  const std::vector<Window> windows = ChooseWindows(options, input.frames.size());
  SurveyResult result;
  for (const Window& window : windows) result.num_sampled += window.end - window.begin;
  progress.Start(result.num_sampled);
  std::vector<WindowResult> measured(windows.size());
  ParallelFor(windows.size(), num_threads, [&](std::size_t i) {
    measured[i] = Measure(input, windows[i], progress);
  });
  progress.Finish();
  result.fixed_parts = FindFixedParts(input, measured);
  for (WindowResult& window : measured) {
    std::ranges::move(window.frames, std::back_inserter(result.frames));
    std::ranges::move(window.skipped, std::back_inserter(result.skipped));
    if (window.alignment.num_edges > 0) result.alignments.push_back(window.alignment);
  }
  return result;
}

}  // namespace nightmap
