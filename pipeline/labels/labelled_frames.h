// SPDX-License-Identifier: Apache-2.0
// The labels of those frames of a list that were asked for, and the masks of what can move in them.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/io/labels_io.h"
#include "pipeline/io/masks_io.h"
#include "pipeline/labels/frame_labeller.h"
#include "pipeline/labels/kept_labels.h"
#include "pipeline/program/stage_context.h"

namespace nightmap {

class LabelledFrames {
 public:
  // Frames whose labels `kept` has are not labelled again; `sources` are the parts of their sources
  // that the frames of a camera share (LabelSource), by camera_idx. Throws UsageError naming the
  // remedy when the model has no network and no frame a label picture.
  LabelledFrames(const SegmentationModel& model,
                 FrameLabeller label,
                 const std::vector<FrameRecord>& frames,
                 KeptLabels kept = {},
                 std::vector<std::string> sources = {});

  // Whether labels of frame i can be had: by the network, or because it has a label picture.
  bool CanLabel(std::size_t i) const;
  // Whether frame i is labelled even if it brings nothing new, so that what moves is looked for
  // often enough; `last` is the frame that was labelled before it. Always with a label picture.
  bool IsDue(std::size_t i, std::size_t last) const;
  // Labels frame i of the list, whose pixels are `images`, and returns where something in it can
  // move. Throws as the labeller. Several threads may call it at once, each for another frame.
  GrayImage Label(std::size_t i, const RgbdImages& images);

  // These two hold the labelled frames in order, and are deterministic as far as the labeller is.
  LabelsShard Labels() const;
  std::vector<PackedMask> Masks() const;
  // All frames; the labelled ones have channels of their labels and mask in the files of that name.
  std::vector<FrameRecord> FramesWithLabels(const std::string& labels,
                                            const std::string& masks) const;
  // For the report: counts of frames, mean share of the pixels of each class that occurs, and per
  // labelled frame its frame_idx and the share of its pixels that can move.
  nlohmann::json Summarize() const;
  // Keeps the labels for the next run, and logs how many are new.
  void Keep() const;
  // Writes all of it to the outputs "labels", "masks" and "frames", and to the report, and keeps
  // it.
  void Write(StageContext& context) const;

 private:
  struct Labelled {
    PackedLabels labels;
    PackedMask mask;
    std::vector<double> class_shares;  // of the pixels
    std::string source;
    bool is_kept = false;
  };

  std::string SourceOf(const FrameRecord& frame) const;  // of its labels

  SegmentationModel model_;
  FrameLabeller label_;
  const std::vector<FrameRecord>& frames_;
  std::vector<std::optional<Labelled>> labelled_;  // by frame
  KeptLabels kept_;
  std::vector<std::string> sources_;  // by camera
};

// Makes what labels the frames by the inputs "model" and "data" of the run, and lists the network
// among its inputs. `frames` must outlive it. Throws as ReadSegmentationModel and LabelledFrames.
LabelledFrames MakeLabelledFrames(const std::vector<FrameRecord>& frames,
                                  const std::vector<RgbdCamera>& cameras,
                                  StageContext& context);

}  // namespace nightmap
