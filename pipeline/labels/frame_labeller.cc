// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/frame_labeller.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/resize_picture.h"
#include "pipeline/labels/segmenter.h"

namespace nightmap {
namespace {

constexpr std::uint8_t kSure = 255;

Segmentation ReadLabels(const FrameRecord& frame,
                        const RgbdCamera& camera,
                        const SegmentationModel& model,
                        const std::filesystem::path& data_root) {
  const std::string& path = frame.others.at(kLabelChannel).path;
  LabelImage stored = ReadLabelImage(data_root / path);
  const Camera picture = camera.Picture();
  if (stored.width != picture.width || stored.height != picture.height) {
    throw DataError("{}: {} x {} labels for a picture of {} x {}",
                    path,
                    stored.width,
                    stored.height,
                    picture.width,
                    picture.height);
  }
  Segmentation result{SampleImage(std::move(stored), camera.color.width, camera.color.height), {}};
  const LabelImage& labels = result.labels;
  const std::uint8_t largest = *std::ranges::max_element(labels.pixels);
  if (largest >= model.classes.names.size()) {
    throw DataError("{}: label {} is none of the {} classes in {}",
                    path,
                    largest,
                    model.classes.names.size(),
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
  if (!model.HasNetwork()) {
    return [=](const FrameRecord& frame, const RgbdImages&) {
      const auto camera_idx = static_cast<std::size_t>(frame.camera_idx);
      return ReadLabels(frame, cameras.at(camera_idx), model, data_root);
    };
  }
  const auto segmenter = std::make_shared<const Segmenter>(model);
  return [=](const FrameRecord&, const RgbdImages& images) {
    return segmenter->Segment(images.color, images.depth);
  };
}

std::string LabelSource(const SegmentationModel& model, const RgbdCamera& camera) {
  return HashBytes(fmt::format("{} {} {} {} {} {} {} {} {} {}\n{}",
                               HashFile("/proc/self/exe"),
                               cv::getBuildInformation(),
                               cv::getCPUFeaturesLine(),
                               model.HasNetwork() ? HashFile(model.network) : "",
                               model.input_width_px,
                               model.input_height_px,
                               model.mean,
                               model.scale,
                               model.is_bgr,
                               model.classes.names.size(),
                               CamerasToJson({camera})));
}

}  // namespace nightmap
