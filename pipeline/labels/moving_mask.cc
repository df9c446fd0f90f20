// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/moving_mask.h"

#include <opencv2/imgproc.hpp>

namespace nightmap {

void MovingMaskOptions::Register(OptionList& list) {
  list.Add("min_confidence",
           &min_confidence,
           Range(0, 1),
           "a pixel counts as moving when its class can move and is at least so probable");
  list.Add("margin_px", &margin_px, Range(0, 100), "widens what moves by so many pixels");
}

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
