// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/moving_mask.h"

#include <opencv2/imgproc.hpp>

namespace nightmap {

GrayImage MovingMask(const Segmentation& segmentation,
                     const LabelClasses& classes,
                     const MovingMaskOptions& options) {
  const LabelImage& labels = segmentation.labels;
  GrayImage mask{labels.width, labels.height, 1, {}};
  mask.pixels.reserve(labels.pixels.size());
  for (std::size_t i = 0; i < labels.pixels.size(); ++i) {
    const bool can_move = classes.moving[labels.pixels[i]] != 0;
    const bool is_sure = segmentation.confidences.pixels[i] >= 255 * options.min_confidence;
    mask.pixels.push_back(can_move && is_sure ? 255 : 0);
  }
  const int size_px = 2 * options.margin_px + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {size_px, size_px});
  const cv::Mat image(mask.height, mask.width, CV_8UC1, mask.pixels.data());
  cv::dilate(image, image, disc);
  return mask;
}

}  // namespace nightmap
