// SPDX-License-Identifier: Apache-2.0
// survey: measures what recordings are like, in a sample of their frames: sharpness, exposure,
// texture, depth, how far frames in succession agree, what stays in place in all pictures. It
// judges nothing.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/frames_io.h"
#include "stages/camera/survey/depth_alignment.h"
#include "stages/camera/survey/fixed_parts.h"
#include "stages/camera/survey/frame_measures.h"
#include "stages/camera/survey/pair_measures.h"

namespace nightmap {

// Pictures are reduced to about this width where single pixels do not matter.
constexpr double kSmallWidth_px = 320;

struct SurveyOptions {
  OPTION(int, max_frames, 300, {1, 1e7},
         "frames that are looked at; of a longer recording, evenly spread windows");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the sampled frames is unreadable");
  REGISTER_OPTIONS();
};

struct SurveyInput {
  std::vector<FrameRecord> frames;  // of all shards, in order
  std::vector<RgbdCamera> cameras;
  // Depth as recorded, whatever the camera's reach (min_depth_m, max_depth_m).
  RgbdLoader load;
};

// A frame of the sample.
struct SurveyedFrame {
  std::size_t frame = 0;  // index in SurveyInput::frames
  FrameMeasures own;
  PairMeasures to_previous;  // the frame before it, if that has the same camera and sequence
};

struct SurveyResult {
  std::vector<SurveyedFrame> frames;       // in order, without those that failed
  std::vector<DepthAlignment> alignments;  // per window
  std::vector<FixedParts> fixed_parts;     // per camera
  std::vector<std::string> skipped;        // reasons, in frame order
  std::size_t num_sampled = 0;
};

// The sample: all frames, or evenly spread windows of consecutive frames. Each window is read with
// the frame before it, so that every frame of it has a predecessor. Deterministic at any number of
// threads.
SurveyResult RunSurvey(const SurveyOptions& options,
                       const SurveyInput& input,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
