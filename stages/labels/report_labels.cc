// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/report_labels.h"

namespace nightmap {

void ReportLabels(const LabelsResult& result,
                  const LabelClasses& classes,
                  std::size_t num_frames,
                  nlohmann::json* report) {
  std::vector<double> sums(classes.names.size());
  std::vector<int> frame_idx;
  std::vector<double> moving_shares;
  int num_mostly_moving = 0;
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    double moving = 0;
    for (std::size_t c = 0; c < sums.size(); ++c) {
      sums[c] += result.class_shares[i][c];
      if (classes.moving[c] != 0) moving += result.class_shares[i][c];
    }
    frame_idx.push_back(result.frames[i].frame_idx);
    moving_shares.push_back(moving);
    num_mostly_moving += moving > 0.5;
  }
  nlohmann::json mean_shares = nlohmann::json::object();
  for (std::size_t c = 0; c < sums.size(); ++c) {
    if (sums[c] > 0) {
      mean_shares[classes.names[c]] = sums[c] / static_cast<double>(result.frames.size());
    }
  }
  (*report)["num_frames"] = num_frames;
  (*report)["num_labelled_frames"] = result.frames.size();
  (*report)["num_frames_mostly_moving"] = num_mostly_moving;
  (*report)["mean_class_shares"] = mean_shares;
  (*report)["labelled_frame_idx"] = frame_idx;
  (*report)["moving_shares"] = moving_shares;
}

}  // namespace nightmap
