// SPDX-License-Identifier: Apache-2.0
// Meaning and origin of labels: the TOML file that a user writes beside an ONNX file.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "pipeline/labels/moving_mask.h"

namespace nightmap {

struct SegmentationModel {
  std::string source = {};  // the model file, for messages
  // ONNX file: 1 x 3 x height x width in, logits per class out. Empty: labels are the recording's.
  std::filesystem::path network = {};
  int input_width_px = 0;
  int input_height_px = 0;
  // The network's input is (value - mean) / scale per channel, in the network's channel order;
  // value is 0 .. 255.
  std::array<double, 3> mean = {0, 0, 0};
  std::array<double, 3> scale = {1, 1, 1};
  bool is_bgr = false;        // channel order; otherwise RGB
  LabelClasses classes = {};  // in the order of the network's outputs
  MovingMaskOptions mask = {};
  // Longest times without a labelled frame: after one in which something moves, and after another.
  double moving_gap_s = 0.05;
  double still_gap_s = 0.3;

  bool HasNetwork() const { return !network.empty(); }
};

// `folder` is what the network's path is relative to. Throws UsageError naming `source`, the line
// where there is one, and the remedy, on an unknown or missing key, a wrong type, a value out of
// range, a class named twice, or an unknown class in `moving`.
SegmentationModel ParseSegmentationModel(std::string_view text,
                                         const std::string& source,
                                         const std::filesystem::path& folder);
// Throws UsageError also when the model file or the network's file is missing.
SegmentationModel ReadSegmentationModel(const std::filesystem::path& path);

}  // namespace nightmap
