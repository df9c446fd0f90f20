// SPDX-License-Identifier: Apache-2.0
// Labels every pixel of a picture with a segmentation network.
#pragma once

#include <memory>

#include "pipeline/io/labels_io.h"
#include "pipeline/labels/segmentation_model.h"

namespace nightmap {

class Segmenter {
 public:
  // Loads the network and runs it on a blank picture. Throws UsageError naming the model file and
  // the remedy when the network does not load, cannot take the input that the model file says, or
  // has another number of outputs than the model file has classes.
  explicit Segmenter(const SegmentationModel& model);
  ~Segmenter();
  Segmenter(const Segmenter&) = delete;
  Segmenter& operator=(const Segmenter&) = delete;

  // The picture is stretched to the network's input, and the probabilities of its classes are
  // brought to the picture's size along edges of color and, where `depth` is not empty, of depth in
  // metres at the color pixels (guided_upsampling.h). The label of a pixel is its most probable
  // class, the smaller index where two are equal; the confidence is 255 times its probability,
  // rounded. Several threads may call it at once: each call has a network of its own. Deterministic
  // as long as the program sets cv::setNumThreads(1). Throws DataError when `depth` has another
  // size than `color`.
  Segmentation Segment(const ColorImage& color, const DepthImage& depth) const;

 private:
  struct Networks;
  SegmentationModel model_;
  std::unique_ptr<Networks> networks_;
};

}  // namespace nightmap
