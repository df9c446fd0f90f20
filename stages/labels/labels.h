// SPDX-License-Identifier: Apache-2.0
// labels: the class of every pixel of some frames of a shard, by a segmentation network.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/labels_io.h"
#include "pipeline/io/masks_io.h"
#include "pipeline/labels/moving_mask.h"
#include "pipeline/labels/segmentation_model.h"

namespace nightmap {

struct LabelsOptions {
  int every_n = 0;
  double labelled_rate_hz = 9;
  MovingMaskOptions mask;
  double max_failed_ratio = 0.2;

  void Register(OptionList& list) {
    list.Add(
        "every_n",
        &every_n,
        Range(0, 1e6),
        "labels every n-th frame, the last, and those between where features would be lost; 0: n "
        "from the frame rate");
    list.Add("labelled_rate_hz",
             &labelled_rate_hz,
             Range(0.01, 1000),
             "labelled frames per second of a recording that every_n = 0 aims at");
    mask.Register(list);
    list.Add("max_failed_ratio",
             &max_failed_ratio,
             Range(0, 1),
             "fails when a larger share of the frames to label failed");
  }
};

// Indices in `frames` of those to label, ascending: every n-th frame of each sequence, from its
// first in the list, and its last. With every_n = 0, n is the median frame rate of the sequence
// over labelled_rate_hz, rounded, and at least 1. Of a model without a network all frames with a
// label picture; throws UsageError naming the remedy when there is none.
std::vector<std::size_t> FramesToLabel(const LabelsOptions& options,
                                       const SegmentationModel& model,
                                       const std::vector<FrameRecord>& frames);

// Labels a frame; called from several threads. Throws when the frame's pixels cannot be read. Any
// exception that FrameFailure catches fails this frame only.
using FrameLabeller = std::function<Segmentation(const FrameRecord&)>;

struct LabelsInput {
  std::vector<FrameRecord> frames;
  std::vector<std::size_t> chosen;  // indices in frames of those to label in any case, ascending
  std::vector<RgbdCamera> cameras;
  LabelClasses classes;
  FrameLabeller label = {};
  // Reads the picture of a frame; may throw as `label`. With it, the frames between the chosen ones
  // are looked at, too.
  std::function<ColorImage(const FrameRecord&)> color = {};
};

struct LabelsResult {
  std::vector<PackedLabels> frames;  // those that were labelled, in order
  std::vector<PackedMask> masks;     // of the same frames
  // Per labelled frame and class, share of the pixels.
  std::vector<std::vector<double>> class_shares;
  std::size_t num_to_label = 0;
  std::vector<std::string> skipped;  // reasons, in frame order
};

// Labels the chosen frames, and those between them to which the features of the labelled frame
// before cannot be followed. Deterministic at any number of threads as far as `label` is.
LabelsResult RunLabels(const LabelsOptions& options,
                       const LabelsInput& input,
                       int num_threads,
                       Progress& progress);

// Adds the mask channel to the frames that have a mask in the file of that name.
void NameMasks(const std::vector<PackedMask>& masks,
               const std::string& file,
               std::vector<FrameRecord>* frames);

}  // namespace nightmap
