// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/segmenter.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/error.h"
#include "pipeline/labels/guided_upsampling.h"

namespace nightmap {
namespace {

std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

cv::dnn::Net Load(const SegmentationModel& model) {
  try {
    cv::dnn::Net network = cv::dnn::readNetFromONNX(model.network.string());
    network.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    return network;
  } catch (const cv::Exception& error) {
    throw UsageError(
        "{}: the network {} does not load ({}): export it to ONNX with layers that OpenCV {} knows",
        model.source,
        model.network.string(),
        OneLine(error.err),
        CV_VERSION);
  }
}

// The network's input: 1 x 3 x height x width.
cv::Mat InputOf(const ColorImage& color, const SegmentationModel& model) {
  const cv::Mat rgb(
      color.height, color.width, CV_8UC3, const_cast<std::uint8_t*>(color.pixels.data()));
  const cv::Size size(model.input_width_px, model.input_height_px);
  cv::Mat small;
  cv::resize(rgb, small, size, 0, 0, cv::INTER_AREA);
  const int sizes[] = {1, 3, size.height, size.width};
  cv::Mat input(4, sizes, CV_32F);
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    cv::Mat values, plane(size, CV_32F, input.ptr<float>(0, c));
    cv::extractChannel(small, values, model.is_bgr ? 2 - c : c);
    values.convertTo(
        plane, CV_32F, 1 / model.scale[channel], -model.mean[channel] / model.scale[channel]);
  }
  return input;
}

// Logits per class: 1 x classes x rows x columns.
cv::Mat Run(cv::dnn::Net& network, const cv::Mat& input) {
  network.setInput(input);
  return network.forward();
}

void CheckTakesInput(cv::dnn::Net& network, const SegmentationModel& model) {
  const ColorImage blank{
      model.input_width_px,
      model.input_height_px,
      3,
      std::vector<std::uint8_t>(3 * static_cast<std::size_t>(model.input_width_px) *
                                static_cast<std::size_t>(model.input_height_px))};
  cv::Mat output;
  try {
    output = Run(network, InputOf(blank, model));
  } catch (const cv::Exception& error) {
    throw UsageError(
        "{}: the network {} does not take one picture of 3 channels, {} x {} pixels ({}): correct "
        "input_width_px and input_height_px",
        model.source,
        model.network.string(),
        model.input_width_px,
        model.input_height_px,
        OneLine(error.err));
  }
  if (output.dims != 4 || output.type() != CV_32F || output.size[0] != 1) {
    throw UsageError(
        "{}: the network {} does not give 1 x classes x rows x columns numbers: export it with the "
        "logits per class as its output",
        model.source,
        model.network.string());
  }
  if (output.size[1] != static_cast<int>(model.classes.names.size())) {
    throw UsageError("{}: the network {} has {} classes, 'classes' names {}: correct 'classes'",
                     model.source,
                     model.network.string(),
                     output.size[1],
                     model.classes.names.size());
  }
}

// Turns logits into probabilities, and returns the classes that are most probable somewhere.
std::vector<int> Softmax(cv::Mat* logits) {
  const int num_classes = logits->size[1];
  const auto num_pixels =
      static_cast<std::size_t>(logits->size[2]) * static_cast<std::size_t>(logits->size[3]);
  float* values = logits->ptr<float>();
  std::vector<bool> wins(static_cast<std::size_t>(num_classes));
  std::vector<float> column(static_cast<std::size_t>(num_classes));
  for (std::size_t i = 0; i < num_pixels; ++i) {
    for (std::size_t c = 0; c < column.size(); ++c) column[c] = values[c * num_pixels + i];
    const auto best = std::ranges::max_element(column);
    const float max = *best;
    wins[static_cast<std::size_t>(best - column.begin())] = true;
    float sum = 0;
    for (float& value : column) sum += value = std::exp(value - max);
    if (!std::isfinite(sum)) throw DataError("the network's output holds NaN or infinity");
    for (std::size_t c = 0; c < column.size(); ++c) values[c * num_pixels + i] = column[c] / sum;
  }
  std::vector<int> classes;
  for (int c = 0; c < num_classes; ++c) {
    if (wins[static_cast<std::size_t>(c)]) classes.push_back(c);
  }
  return classes;
}

Plane PlaneOf(const cv::Mat& probabilities, int channel) {
  const float* begin = probabilities.ptr<float>(0, channel);
  Plane plane{probabilities.size[3], probabilities.size[2], 1, {}};
  plane.pixels.assign(begin, begin + probabilities.size[2] * probabilities.size[3]);
  return plane;
}

Segmentation MostProbable(const std::vector<Plane>& planes, const std::vector<int>& classes) {
  const int width = planes[0].width;
  const int height = planes[0].height;
  const std::size_t num_pixels = planes[0].pixels.size();
  Segmentation result{{width, height, 1, {}}, {width, height, 1, {}}};
  result.labels.pixels.resize(num_pixels);
  result.confidences.pixels.resize(num_pixels);
  for (std::size_t i = 0; i < num_pixels; ++i) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < planes.size(); ++c) {
      if (planes[c].pixels[i] > planes[best].pixels[i]) best = c;
    }
    const float probability = std::clamp(planes[best].pixels[i], 0.0F, 1.0F);
    result.labels.pixels[i] = static_cast<std::uint8_t>(classes[best]);
    result.confidences.pixels[i] = static_cast<std::uint8_t>(std::lround(255 * probability));
  }
  return result;
}

}  // namespace

// Networks that no call uses at the moment. A network holds the values of its layers, so that each
// call needs its own.
struct Segmenter::Networks {
  std::mutex mutex;
  std::vector<cv::dnn::Net> idle;

  cv::dnn::Net Take(const SegmentationModel& model) {
    {
      const std::lock_guard lock(mutex);
      if (!idle.empty()) {
        cv::dnn::Net network = idle.back();
        idle.pop_back();
        return network;
      }
    }
    return Load(model);
  }
  void GiveBack(const cv::dnn::Net& network) {
    const std::lock_guard lock(mutex);
    idle.push_back(network);
  }
};

Segmenter::Segmenter(const SegmentationModel& model)
    : model_(model), networks_(std::make_unique<Networks>()) {
  cv::dnn::Net network = Load(model);
  CheckTakesInput(network, model);
  networks_->GiveBack(network);
}

Segmenter::~Segmenter() = default;

Segmentation Segmenter::Segment(const ColorImage& color, const DepthImage& depth) const {
  const bool fits = depth.width == color.width && depth.height == color.height;
  if (!depth.pixels.empty() && !fits) {
    throw DataError("depth has {} x {} pixels, color {} x {}",
                    depth.width,
                    depth.height,
                    color.width,
                    color.height);
  }
  cv::dnn::Net network = networks_->Take(model_);
  cv::Mat probabilities = Run(network, InputOf(color, model_)).clone();
  networks_->GiveBack(network);
  const std::vector<int> classes = Softmax(&probabilities);
  std::vector<Plane> planes;
  for (const int c : classes) planes.push_back(PlaneOf(probabilities, c));
  return MostProbable(UpsampleAlongEdges(planes, color, depth), classes);
}

}  // namespace nightmap
