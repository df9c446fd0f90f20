// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/extract_features.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <tuple>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/io/masked_pixels.h"

namespace nightmap {
namespace {

constexpr double kSiftEdgeThreshold = 10.0;  // higher keeps more edge-like features
constexpr int kSiftNumOctaveLayers = 3;      // layers per octave
constexpr int kOrbPatch_px = 31;
constexpr int kBriskPatch_px = 12;
constexpr int kMaskedExcess = 2;  // a mask takes some of the keypoints away, at its edges above all
// A mask may leave a bare wall. With fewer keypoints the pose of a frame hangs by a few.
constexpr int kFew = 300;
constexpr int kWeaker = 3;

cv::Mat MatOf(const GrayImage& gray) {
  return {gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data())};
}

struct Detector {
  std::string name;
  DescriptorKind kind;
  // It also detects the keypoints where `detect` is null, of which SIFT and ORB keep the strongest.
  cv::Ptr<cv::Feature2D> (*make_describer)(const ExtractionOptions& options, int num_kept);
  std::vector<cv::KeyPoint> (*detect)(const GrayImage& gray, const ExtractionOptions& options);
};

// OpenCV keeps all ties with the last one, so KeepStrongest decides among them.
cv::Ptr<cv::Feature2D> MakeSift(const ExtractionOptions& options, int num_kept) {
  return cv::SIFT::create(
      num_kept, kSiftNumOctaveLayers, options.sift_contrast_threshold, kSiftEdgeThreshold, 1.6);
}

template <int kBorder_px>
cv::Ptr<cv::Feature2D> MakeOrb(const ExtractionOptions& options, int num_kept) {
  return cv::ORB::create(2 * num_kept,
                         1.2f,
                         8,
                         kBorder_px,
                         0,
                         2,
                         cv::ORB::HARRIS_SCORE,
                         kOrbPatch_px,
                         options.fast_threshold);
}

cv::Ptr<cv::Feature2D> MakeBrisk(const ExtractionOptions& options, int) {
  return cv::BRISK::create(options.fast_threshold);
}

// Corners at one scale, without orientation. The describer treats each as upright, with the size
// that it gives to its own keypoints at full resolution.
template <int kPatch_px>
std::vector<cv::KeyPoint> FastCorners(const GrayImage& gray, const ExtractionOptions& options) {
  std::vector<cv::KeyPoint> corners;
  cv::FAST(MatOf(gray), corners, options.fast_threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  for (cv::KeyPoint& corner : corners) {
    corner.size = kPatch_px;
    corner.angle = 0;
    corner.octave = 0;
  }
  return corners;
}

// Corners at one scale, with orientation, so that the describer turns its pattern with the picture.
std::vector<cv::KeyPoint> HarrisKeypoints(const GrayImage& gray, const ExtractionOptions& options) {
  std::vector<cv::KeyPoint> keypoints;
  for (const HarrisCorner& corner : FindHarrisCorners(gray, options.harris)) {
    keypoints.emplace_back(corner.pixel.x(),
                           corner.pixel.y(),
                           static_cast<float>(kOrbPatch_px),
                           corner.angle_deg,
                           corner.response,
                           0);
  }
  return keypoints;
}

const std::vector<Detector>& Detectors() {
  static const std::vector<Detector> detectors = {
      {"sift", DescriptorKind::kRootSift, MakeSift, nullptr},
      {"orb", DescriptorKind::kOrb, MakeOrb<kOrbPatch_px>, nullptr},
      {"brisk", DescriptorKind::kBrisk, MakeBrisk, nullptr},
      {"fast_orb", DescriptorKind::kOrb, MakeOrb<kOrbPatch_px>, FastCorners<kOrbPatch_px>},
      {"fast_brisk", DescriptorKind::kBrisk, MakeBrisk, FastCorners<kBriskPatch_px>},
      {"harris", DescriptorKind::kOrb, MakeOrb<kHarrisBorder_px>, HarrisKeypoints}};
  return detectors;
}

const Detector& DetectorOf(const ExtractionOptions& options) {
  const auto found = std::ranges::find(Detectors(), options.detector, &Detector::name);
  if (found == Detectors().end()) throw UsageError("unknown detector '{}'", options.detector);
  return *found;
}

// OpenCV's SIFT doubles the image about its edges but halves keypoints about the first pixel's
// centre, so all of them lie a quarter of a pixel too far right and down (opencv/opencv issue
// 23123).
void CentreOnPixels(DescriptorKind kind, std::vector<cv::KeyPoint>* keypoints) {
  if (kind != DescriptorKind::kRootSift) return;
  for (cv::KeyPoint& keypoint : *keypoints) keypoint.pt -= cv::Point2f(0.25f, 0.25f);
}

// Strongest first. A total order, so that equal responses cannot reorder features between runs.
bool IsStronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::tie(b.response, a.pt.y, a.pt.x, a.size, a.angle) <
         std::tie(a.response, b.pt.y, b.pt.x, b.size, b.angle);
}

// Keeps the strongest keypoints outside of the mask, in order, and their descriptor rows.
void KeepStrongest(int count,
                   const GrayImage& moving,
                   std::vector<cv::KeyPoint>* keypoints,
                   cv::Mat* descriptors) {
  std::vector<std::size_t> order(keypoints->size());
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [&](std::size_t i) {
    const cv::Point2f& pixel = (*keypoints)[i].pt;
    return IsMasked(moving, {pixel.x, pixel.y});
  });
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return IsStronger((*keypoints)[a], (*keypoints)[b]);
  });
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  std::vector<cv::KeyPoint> kept;
  cv::Mat rows;
  for (const std::size_t i : order) {
    kept.push_back((*keypoints)[i]);
    rows.push_back(descriptors->row(static_cast<int>(i)));
  }
  *keypoints = std::move(kept);
  *descriptors = rows;
}

// L1-normalizes and takes the root, so that Euclidean distance compares histograms by Hellinger's.
void AppendRootSift(const cv::Mat& descriptors, std::vector<std::uint8_t>* bytes) {
  for (int row = 0; row < descriptors.rows; ++row) {
    const float* values = descriptors.ptr<float>(row);
    const float sum = std::max(1e-6f, std::accumulate(values, values + 128, 0.0f));
    for (int i = 0; i < 128; ++i) {
      const float root = 512.0f * std::sqrt(values[i] / sum);
      bytes->push_back(static_cast<std::uint8_t>(std::min(255.0f, std::round(root))));
    }
  }
}

// The strongest keypoints outside of the mask, and a row of descriptors for each.
std::pair<std::vector<cv::KeyPoint>, cv::Mat> Detect(const GrayImage& gray,
                                                     const ExtractionOptions& options,
                                                     const GrayImage& moving) {
  const Detector& detector = DetectorOf(options);
  const int num_kept = (IsAnyMasked(moving) ? kMaskedExcess : 1) * options.num_features;
  const auto describer = detector.make_describer(options, num_kept);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  if (detector.detect) keypoints = detector.detect(gray, options);
  // One call, because detect() and compute() would each build the image pyramid.
  describer->detectAndCompute(
      MatOf(gray), cv::noArray(), keypoints, descriptors, detector.detect != nullptr);
  CentreOnPixels(detector.kind, &keypoints);
  KeepStrongest(options.num_features, moving, &keypoints, &descriptors);
  return {std::move(keypoints), descriptors};
}

// Finds keypoints of less contrast, up to the number that is enough.
ExtractionOptions Weaker(ExtractionOptions options) {
  options.sift_contrast_threshold /= kWeaker;
  options.fast_threshold = std::max(1, options.fast_threshold / kWeaker);
  options.harris.min_gradient /= kWeaker;
  options.num_features = std::min(options.num_features, kFew);
  return options;
}

void AppendBinary(const cv::Mat& descriptors, std::vector<std::uint8_t>* bytes) {
  for (int row = 0; row < descriptors.rows; ++row) {
    const std::uint8_t* values = descriptors.ptr<std::uint8_t>(row);
    bytes->insert(bytes->end(), values, values + descriptors.cols);
  }
}

}  // namespace

std::vector<std::string> DetectorNames() {
  std::vector<std::string> names;
  for (const Detector& one : Detectors()) names.push_back(one.name);
  return names;
}

DescriptorKind ExtractionOptions::Kind() const { return DetectorOf(*this).kind; }

FrameFeatures ExtractFeatures(const ColorImage& color,
                              const Camera& camera,
                              const ExtractionOptions& options,
                              const GrayImage& moving) {
  const GrayImage gray = ToGray(color);
  auto [keypoints, descriptors] = Detect(gray, options, moving);
  if (IsAnyMasked(moving) && static_cast<int>(keypoints.size()) < kFew) {
    std::tie(keypoints, descriptors) = Detect(gray, Weaker(options), moving);
  }

  FrameFeatures features;
  for (const cv::KeyPoint& keypoint : keypoints) {
    const Eigen::Vector2d raw(keypoint.pt.x, keypoint.pt.y);
    features.raw_keypoints_px.push_back(raw.cast<float>());
    features.keypoints_px.push_back(camera.Undistort(raw).cast<float>());
    features.scales_px.push_back(keypoint.size);
  }
  features.depths_m.assign(keypoints.size(), 0.0f);
  if (options.Kind() == DescriptorKind::kRootSift) {
    AppendRootSift(descriptors, &features.descriptors);
  } else {
    AppendBinary(descriptors, &features.descriptors);
  }
  return features;
}

}  // namespace nightmap
