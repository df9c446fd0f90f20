// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/labels.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/frame_reader.h"
#include "stages/labels/flow_follower.h"

namespace nightmap {
namespace {

// Frames [begin, end) of one sequence.
struct Stretch {
  std::size_t begin;
  std::size_t end;
};

std::vector<Stretch> Sequences(const std::vector<FrameRecord>& frames) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 0 || frames[i].sequence_idx != frames[i - 1].sequence_idx) {
      stretches.push_back({i, i});
    }
    stretches.back().end = i + 1;
  }
  return stretches;
}

std::size_t StepOf(const LabelsOptions& options,
                   const std::vector<FrameRecord>& frames,
                   const Stretch& stretch) {
  if (options.every_n > 0) return static_cast<std::size_t>(options.every_n);
  std::vector<std::int64_t> gaps_ns;
  for (std::size_t i = stretch.begin + 1; i < stretch.end; ++i) {
    gaps_ns.push_back(frames[i].time_ns - frames[i - 1].time_ns);
  }
  if (gaps_ns.empty()) return 1;
  const auto median = gaps_ns.begin() + static_cast<std::ptrdiff_t>(gaps_ns.size() / 2);
  std::ranges::nth_element(gaps_ns, median);
  const double gap_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(*median, 1));
  const double step = std::round(1 / (gap_s * options.labelled_rate_hz));
  return static_cast<std::size_t>(std::clamp(step, 1.0, static_cast<double>(frames.size())));
}

std::vector<std::size_t> FramesWithLabels(const SegmentationModel& model,
                                          const std::vector<FrameRecord>& frames) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].others.contains(kLabelChannel)) chosen.push_back(i);
  }
  if (chosen.empty() && !frames.empty()) {
    throw UsageError(
        "{} names no network, and the frames have no label pictures: name `network` there, or "
        "`label_folder` in the [[sequence]] of the site config",
        model.source);
  }
  return chosen;
}

std::vector<double> ClassShares(const LabelImage& labels, std::size_t num_classes) {
  std::vector<double> shares(num_classes);
  for (const std::uint8_t label : labels.pixels) ++shares.at(label);
  for (double& share : shares) share /= static_cast<double>(labels.pixels.size());
  return shares;
}

struct LabelledFrame {
  PackedLabels labels = {};
  PackedMask mask = {};
  std::vector<double> class_shares = {};
  std::string failure = {};  // the reason, and the rest is empty
};

LabelledFrame Label(const LabelsOptions& options,
                    const LabelsInput& input,
                    const FrameRecord& frame) {
  LabelledFrame result;
  result.failure = FrameFailure(frame.color.path, [&] {
    const Segmentation segmentation = input.label(frame);
    result.labels = PackLabels(frame.frame_idx, frame.time_ns, segmentation);
    result.mask = PackMask(frame.time_ns, MovingMask(segmentation, input.classes, options.mask));
    result.class_shares = ClassShares(segmentation.labels, input.classes.names.size());
  });
  return result;
}

// Labels the first frame of a stretch, and those after it to which no labelled one can be followed.
std::vector<LabelledFrame> LabelStretch(const LabelsOptions& options,
                                        const LabelsInput& input,
                                        const Stretch& stretch) {
  std::vector<LabelledFrame> labelled;
  FlowFollower follower(input.cameras);
  for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
    const FrameRecord& frame = input.frames[i];
    ColorImage color;
    std::string failure;
    if (stretch.end > stretch.begin + 1) {
      failure = FrameFailure(frame.color.path, [&] { color = input.color(frame); });
    }
    if (!failure.empty()) {
      labelled.push_back({.failure = failure});
      continue;
    }
    if (i > stretch.begin && follower.Follows(frame, color)) continue;
    labelled.push_back(Label(options, input, frame));
    if (labelled.back().failure.empty() && !color.pixels.empty()) {
      follower.Start(frame, color, UnpackMask(labelled.back().mask));
    }
  }
  return labelled;
}

void Append(std::vector<LabelledFrame> labelled, LabelsResult* result) {
  for (LabelledFrame& frame : labelled) {
    ++result->num_to_label;
    if (!frame.failure.empty()) {
      result->skipped.push_back(std::move(frame.failure));
      continue;
    }
    result->frames.push_back(std::move(frame.labels));
    result->masks.push_back(std::move(frame.mask));
    result->class_shares.push_back(std::move(frame.class_shares));
  }
}

}  // namespace

std::vector<std::size_t> FramesToLabel(const LabelsOptions& options,
                                       const SegmentationModel& model,
                                       const std::vector<FrameRecord>& frames) {
  if (!model.HasNetwork()) return FramesWithLabels(model, frames);
  std::vector<std::size_t> chosen;
  for (const Stretch& stretch : Sequences(frames)) {
    const std::size_t step = StepOf(options, frames, stretch);
    for (std::size_t i = stretch.begin; i < stretch.end; i += step) chosen.push_back(i);
    if (chosen.back() + 1 != stretch.end) chosen.push_back(stretch.end - 1);
  }
  return chosen;
}

LabelsResult RunLabels(const LabelsOptions& options,
                       const LabelsInput& input,
                       int num_threads,
                       Progress& progress) {
  const std::size_t num_chosen = input.chosen.size();
  std::vector<std::vector<LabelledFrame>> labelled(num_chosen);  // from each chosen one to the next
  progress.Start(num_chosen);
  ParallelFor(num_chosen, num_threads, [&](std::size_t i) {
    const std::size_t first = input.chosen[i];
    const bool is_last = i + 1 == num_chosen || !input.color;
    labelled[i] = LabelStretch(options, input, {first, is_last ? first + 1 : input.chosen[i + 1]});
    progress.Advance();
  });
  LabelsResult result;
  for (std::vector<LabelledFrame>& stretch : labelled) Append(std::move(stretch), &result);
  return result;
}

void NameMasks(const std::vector<PackedMask>& masks,
               const std::string& file,
               std::vector<FrameRecord>* frames) {
  std::size_t next = 0;
  for (FrameRecord& frame : *frames) {
    if (next == masks.size() || masks[next].time_ns != frame.time_ns) continue;
    frame.others[kMaskChannel] = {file, HashOf(masks[next++])};
  }
}

}  // namespace nightmap
