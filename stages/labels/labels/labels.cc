// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/labels/labels.h"

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"

namespace nightmap {

LabelsResult RunLabels(const std::vector<FrameRecord>& frames,
                       const std::function<RgbdImages(const FrameRecord&)>& load,
                       LabelledFrames* labelled,
                       Progress& progress,
                       int num_threads) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (labelled->CanLabel(i)) chosen.push_back(i);
  }
  std::vector<std::string> failures(chosen.size());
  progress.Start(chosen.size());
  ParallelFor(chosen.size(), num_threads, [&](std::size_t k) {
    const FrameRecord& frame = frames[chosen[k]];
    failures[k] = FrameFailure(frame.color.path, [&] { labelled->Label(chosen[k], load(frame)); });
    progress.Advance();
  });
  LabelsResult result{.num_to_label = chosen.size(), .skipped = {}};
  for (std::string& failure : failures) {
    if (!failure.empty()) result.skipped.push_back(std::move(failure));
  }
  return result;
}

}  // namespace nightmap
