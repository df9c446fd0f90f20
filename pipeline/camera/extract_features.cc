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

constexpr int kOrbPatch_px = 31;
constexpr int kBriskPatch_px = 12;
constexpr int kMaskedExcess = 2;  // a mask takes some of the keypoints away, at its edges above all
// A mask may leave a bare wall. With fewer keypoints the pose of a frame hangs by a few.
constexpr int kFew = 300;
constexpr int kWeaker = 3;

bool IsFast(const ExtractionOptions& options) { return options.detector.starts_with("fast_"); }
bool IsHarris(const ExtractionOptions& options) { return options.detector == "harris"; }

// Makes the describer. Except for FAST and Harris corners it also detects the keypoints, of which
// SIFT and ORB keep the strongest ones.
cv::Ptr<cv::Feature2D> MakeDescriber(const ExtractionOptions& options, int num_kept) {
  switch (options.Kind()) {
    case DescriptorKind::kRootSift:
      // OpenCV keeps all ties with the last one, so KeepStrongest decides among them.
      return cv::SIFT::create(num_kept,
                              options.sift_num_octave_layers,
                              options.sift_contrast_threshold,
                              options.sift_edge_threshold,
                              1.6);
    case DescriptorKind::kOrb:
      return cv::ORB::create(2 * num_kept,
                             1.2f,
                             8,
                             IsHarris(options) ? kHarrisBorder_px : kOrbPatch_px,
                             0,
                             2,
                             cv::ORB::HARRIS_SCORE,
                             kOrbPatch_px,
                             options.fast_threshold);
    case DescriptorKind::kBrisk:
      return cv::BRISK::create(options.fast_threshold);
  }
  throw UsageError("unknown detector '{}'", options.detector);
}

// Corners at one scale, without orientation. The describer treats each as upright, with the size
// that it gives to its own keypoints at full resolution.
std::vector<cv::KeyPoint> FastCorners(const cv::Mat& image, const ExtractionOptions& options) {
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image, corners, options.fast_threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  for (cv::KeyPoint& corner : corners) {
    corner.size = options.Kind() == DescriptorKind::kOrb ? kOrbPatch_px : kBriskPatch_px;
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
  const cv::Mat image(
      gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data()));
  const int num_kept = (IsAnyMasked(moving) ? kMaskedExcess : 1) * options.num_features;
  const auto describer = MakeDescriber(options, num_kept);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  if (IsFast(options)) keypoints = FastCorners(image, options);
  if (IsHarris(options)) keypoints = HarrisKeypoints(gray, options);
  const bool are_given = IsFast(options) || IsHarris(options);
  // One call, because detect() and compute() would each build the image pyramid.
  describer->detectAndCompute(image, cv::noArray(), keypoints, descriptors, are_given);
  CentreOnPixels(options.Kind(), &keypoints);
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

struct DepthSample {
  float depth_m;
  int distance2_px;  // squared distance to the keypoint
};

std::vector<DepthSample> SampleWindow(const DepthImage& depth, int x, int y, int half_size) {
  std::vector<DepthSample> samples;
  for (int dy = -half_size; dy <= half_size; ++dy) {
    for (int dx = -half_size; dx <= half_size; ++dx) {
      const int u = x + dx;
      const int v = y + dy;
      if (u < 0 || v < 0 || u >= depth.width || v >= depth.height) continue;
      const float value = depth.At(u, v);
      if (value > 0) samples.push_back({value, dx * dx + dy * dy});
    }
  }
  return samples;
}

// Mean depth of the samples on the surface of the sample nearest to the keypoint; 0 when the
// keypoint itself has no depth and the window shows more than one surface.
float SurfaceDepth_m(std::vector<DepthSample> samples, double max_step) {
  if (samples.empty()) return 0;
  const DepthSample nearest = *std::ranges::min_element(samples, {}, [](const DepthSample& sample) {
    return std::pair(sample.distance2_px, sample.depth_m);
  });
  const auto tolerance_m = static_cast<float>(max_step) * nearest.depth_m;
  double sum = 0;
  int count = 0;
  for (const DepthSample& sample : samples) {
    if (std::abs(sample.depth_m - nearest.depth_m) > tolerance_m) continue;
    sum += sample.depth_m;
    ++count;
  }
  const bool is_one_surface = count == static_cast<int>(samples.size());
  if (nearest.distance2_px > 0 && !is_one_surface) return 0;
  return static_cast<float>(sum / count);
}

}  // namespace

void ExtractionOptions::Register(OptionList& list) {
  list.Add("detector",
           &detector,
           {"sift", "orb", "brisk", "fast_orb", "fast_brisk", "harris"},
           "keypoints and descriptors; fast_: FAST corners of one scale, described upright; "
           "harris: Harris corners of one scale, described as by ORB at any angle. SURF is missing "
           "because it is patented and Debian's OpenCV is built without it");
  list.Add("num_features",
           &num_features,
           Range(50, 20000),
           "number of features kept per image, strongest first");
  list.Add("sift_contrast_threshold",
           &sift_contrast_threshold,
           Range(0, 0.2),
           "lower finds more features on weak texture");
  list.Add("sift_edge_threshold",
           &sift_edge_threshold,
           Range(1, 100),
           "higher keeps more edge-like features");
  list.Add("sift_num_octave_layers", &sift_num_octave_layers, Range(1, 8), "layers per octave");
  list.Add("fast_threshold",
           &fast_threshold,
           Range(1, 100),
           "threshold of ORB, BRISK and FAST, in gray levels");
  list.Add("harris_min_gradient",
           &harris.min_gradient,
           Range(0.1, 100),
           "weakest Harris corner, by its gradient in every direction, in gray levels per pixel");
  list.Add("harris_max_per_cell",
           &harris.max_per_cell,
           Range(1, 1000),
           "Harris corners kept in each of 8 x 6 cells of the picture, strongest first");
  list.Add("depth_window_px",
           &depth_window_px,
           Range(0, 10),
           "half size of the window for a keypoint's depth lookup");
  list.Add("max_depth_step",
           &max_depth_step,
           Range(0.001, 1),
           "relative depth difference that separates two surfaces");
}

DescriptorKind ExtractionOptions::Kind() const {
  if (detector == "sift") return DescriptorKind::kRootSift;
  return detector.ends_with("orb") || detector == "harris" ? DescriptorKind::kOrb
                                                           : DescriptorKind::kBrisk;
}

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

void LookUpDepth(const DepthImage& depth,
                 const ExtractionOptions& options,
                 FrameFeatures* features) {
  for (std::size_t i = 0; i < features->raw_keypoints_px.size(); ++i) {
    const Eigen::Vector2f& raw = features->raw_keypoints_px[i];
    const auto x = static_cast<int>(std::lround(raw.x()));
    const auto y = static_cast<int>(std::lround(raw.y()));
    features->depths_m[i] =
        SurfaceDepth_m(SampleWindow(depth, x, y, options.depth_window_px), options.max_depth_step);
  }
}

}  // namespace nightmap
