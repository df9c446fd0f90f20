// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/frame_labeller.h"

#include <algorithm>
#include <memory>

#include "pipeline/base/error.h"
#include "pipeline/labels/segmenter.h"

namespace nightmap {
namespace {

constexpr std::uint8_t kSure = 255;

Segmentation ReadLabels(const FrameRecord& frame,
                        const Camera& camera,
                        const SegmentationModel& model,
                        const std::filesystem::path& data_root) {
  const std::string& path = frame.others.at(kLabelChannel).path;
  Segmentation result{ReadGrayImage(data_root / path), {}};
  const LabelImage& labels = result.labels;
  if (labels.width != camera.width || labels.height != camera.height) {
    throw DataError("{}: {} x {} labels for a picture of {} x {}",
                    path,
                    labels.width,
                    labels.height,
                    camera.width,
                    camera.height);
  }
  const std::uint8_t largest = *std::ranges::max_element(labels.pixels);
  if (largest >= model.classes.size()) {
    throw DataError("{}: label {} is none of the {} classes in {}",
                    path,
                    largest,
                    model.classes.size(),
                    model.source);
  }
  result.confidences = {labels.width, labels.height, 1, {}};
  result.confidences.pixels.assign(labels.pixels.size(), kSure);
  return result;
}

}  // namespace

void CheckModel(const std::filesystem::path& path) {
  const SegmentationModel model = ReadSegmentationModel(path);
  if (model.HasNetwork()) Segmenter{model};
}

FrameLabeller MakeLabeller(const SegmentationModel& model,
                           const std::vector<RgbdCamera>& cameras,
                           const std::filesystem::path& data_root) {
  const auto camera_of = [cameras](const FrameRecord& frame) {
    return cameras.at(static_cast<std::size_t>(frame.camera_idx));
  };
  if (!model.HasNetwork()) {
    return [=](const FrameRecord& frame) {
      return ReadLabels(frame, camera_of(frame).color, model, data_root);
    };
  }
  const auto segmenter = std::make_shared<const Segmenter>(model);
  return [=](const FrameRecord& frame) {
    const RgbdCamera camera = camera_of(frame);
    const RgbdImages images = LoadRgbd(frame, camera, data_root);
    return segmenter->Segment(images.color, images.depth);
  };
}

std::function<ColorImage(const FrameRecord&)> MakeColorReader(
    const std::vector<RgbdCamera>& cameras, const std::filesystem::path& data_root) {
  return [=](const FrameRecord& frame) {
    return LoadColor(frame, cameras.at(static_cast<std::size_t>(frame.camera_idx)), data_root);
  };
}

}  // namespace nightmap
