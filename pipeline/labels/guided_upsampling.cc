// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/guided_upsampling.h"

#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace nightmap {
namespace {

// Chosen by person IoU on photographs and on a recording with pasted people.
constexpr int kRadius_px = 8;          // of a window, at the network's resolution
constexpr float kEpsilon = 1e-3F;      // smaller variances of the guide count as noise; 0 .. 1
constexpr float kInverseDepth_m = 1;   // a change of 1 / m counts like one from black to white
constexpr int kNumGuides = 4;          // red, green, blue, inverse depth
constexpr float kMinMeasured = 0.02F;  // share of a window that tells its inverse depth

using Guides = std::array<cv::Mat, kNumGuides>;

cv::Mat Resized(const cv::Mat& image, cv::Size size) {
  cv::Mat resized;
  const bool shrinks = size.width < image.cols && size.height < image.rows;
  const bool can_average = image.channels() <= 4;  // that is all that OpenCV averages
  cv::resize(
      image, resized, size, 0, 0, shrinks && can_average ? cv::INTER_AREA : cv::INTER_LINEAR);
  return resized;
}

cv::Mat Mean(const cv::Mat& plane, int radius_px) {
  cv::Mat mean;
  const cv::Size size(2 * radius_px + 1, 2 * radius_px + 1);
  cv::boxFilter(plane, mean, CV_32F, size, {-1, -1}, true, cv::BORDER_REFLECT);
  return mean;
}

// Inverse depth at the small size; holes get that of the smallest window around them that holds
// measurements.
cv::Mat SmallInverseDepth(const cv::Mat& inverse, const cv::Mat& is_measured, cv::Size size) {
  const cv::Mat sum = Resized(inverse, size);
  const cv::Mat share = Resized(is_measured, size);
  cv::Mat filled = cv::Mat::zeros(size, CV_32F);
  cv::Mat holes = cv::Mat(size, CV_8U, cv::Scalar(255));
  for (int radius_px = 0; radius_px <= 64; radius_px = 2 * radius_px + 1) {
    const cv::Mat window_share = Mean(share, radius_px);
    const cv::Mat found = holes & (window_share > kMinMeasured);
    cv::Mat(Mean(sum, radius_px) / window_share).copyTo(filled, found);
    holes &= ~found;
  }
  return filled;
}

// The guides in 0 .. 1 at the picture's size and at the small one.
void MakeGuides(
    const ColorImage& color, const DepthImage& depth, cv::Size size, Guides* full, Guides* small) {
  const cv::Mat rgb(
      color.height, color.width, CV_8UC3, const_cast<std::uint8_t*>(color.pixels.data()));
  cv::Mat values;
  rgb.convertTo(values, CV_32F, 1.0 / 255);
  cv::split(values, full->data());
  cv::split(Resized(values, size), small->data());
  (*full)[3] = cv::Mat::zeros(rgb.size(), CV_32F);
  (*small)[3] = cv::Mat::zeros(size, CV_32F);
  if (depth.pixels.empty()) return;
  const cv::Mat depth_m(depth.height, depth.width, CV_32F, const_cast<float*>(depth.pixels.data()));
  const cv::Mat measured = depth_m > 0;
  cv::Mat is_measured;
  measured.convertTo(is_measured, CV_32F, 1.0 / 255);
  cv::Mat inverse = cv::Mat::zeros(rgb.size(), CV_32F);
  cv::Mat(kInverseDepth_m / depth_m).copyTo(inverse, measured);
  (*small)[3] = SmallInverseDepth(inverse, is_measured, size);
  (*full)[3] = Resized((*small)[3], rgb.size());
  inverse.copyTo((*full)[3], measured);
}

// Cholesky factors and means of the guides' covariances in the windows around the small pixels.
class WindowFits {
 public:
  using Vector = cv::Vec<float, kNumGuides>;
  using Coefficients = cv::Vec<float, kNumGuides + 1>;  // the last one is the offset

  explicit WindowFits(const Guides& guides) : guides_(guides) {
    for (std::size_t i = 0; i < kNumGuides; ++i) means_[i] = Mean(guides[i], kRadius_px);
    factors_.create(guides[0].size());
    for (std::size_t i = 0; i < kNumGuides; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const cv::Mat covariance =
            Mean(guides[i].mul(guides[j]), kRadius_px) - means_[i].mul(means_[j]);
        SetElement(covariance, static_cast<int>(i), static_cast<int>(j));
      }
    }
    factors_.forEach([](Matrix& matrix, const int*) { Factorize(&matrix); });
  }

  // Coefficients of the linear functions that the plane has in the windows, their mean per pixel.
  cv::Mat Fit(const cv::Mat& plane) const {
    const cv::Mat mean = Mean(plane, kRadius_px);
    std::array<cv::Mat, kNumGuides> covariances;
    for (std::size_t i = 0; i < kNumGuides; ++i) {
      covariances[i] = Mean(guides_[i].mul(plane), kRadius_px) - means_[i].mul(mean);
    }
    cv::Mat_<Coefficients> fits(plane.size());
    for (int y = 0; y < plane.rows; ++y) {
      for (int x = 0; x < plane.cols; ++x) {
        Vector v;
        for (int i = 0; i < kNumGuides; ++i) v[i] = At(covariances, i, y, x);
        v = Solve(factors_(y, x), v);
        Coefficients& fit = fits(y, x);
        fit[kNumGuides] = mean.at<float>(y, x);
        for (int i = 0; i < kNumGuides; ++i) {
          fit[i] = v[i];
          fit[kNumGuides] -= v[i] * At(means_, i, y, x);
        }
      }
    }
    return Mean(fits, kRadius_px);
  }

 private:
  using Matrix = cv::Matx<float, kNumGuides, kNumGuides>;

  static float At(const Guides& planes, int i, int y, int x) {
    return planes[static_cast<std::size_t>(i)].at<float>(y, x);
  }

  void SetElement(const cv::Mat& values, int i, int j) {
    for (int y = 0; y < values.rows; ++y) {
      for (int x = 0; x < values.cols; ++x) {
        factors_(y, x)(i, j) = values.at<float>(y, x) + (i == j ? kEpsilon : 0);
      }
    }
  }

  static void Factorize(Matrix* matrix) {
    Matrix& l = *matrix;
    for (int i = 0; i < kNumGuides; ++i) {
      for (int j = 0; j <= i; ++j) {
        float sum = l(i, j);
        for (int k = 0; k < j; ++k) sum -= l(i, k) * l(j, k);
        // Rounding can bring a variance below the epsilon that was added to it.
        l(i, j) = i == j ? std::sqrt(std::max(sum, 0.5F * kEpsilon)) : sum / l(j, j);
      }
    }
  }

  static Vector Solve(const Matrix& l, Vector v) {
    for (int i = 0; i < kNumGuides; ++i) {
      for (int k = 0; k < i; ++k) v[i] -= l(i, k) * v[k];
      v[i] /= l(i, i);
    }
    for (int i = kNumGuides - 1; i >= 0; --i) {
      for (int k = i + 1; k < kNumGuides; ++k) v[i] -= l(k, i) * v[k];
      v[i] /= l(i, i);
    }
    return v;
  }

  const Guides& guides_;
  Guides means_;
  cv::Mat_<Matrix> factors_;  // lower triangles
};

Plane Apply(const cv::Mat& fits, const Guides& guides) {
  const cv::Mat_<WindowFits::Coefficients> full = Resized(fits, guides[0].size());
  Plane result{full.cols, full.rows, 1, {}};
  result.pixels.reserve(full.total());
  for (int y = 0; y < full.rows; ++y) {
    const WindowFits::Coefficients* fit = full[y];
    for (int x = 0; x < full.cols; ++x, ++fit) {
      float value = (*fit)[kNumGuides];
      for (int i = 0; i < kNumGuides; ++i) {
        value += (*fit)[i] * guides[static_cast<std::size_t>(i)].at<float>(y, x);
      }
      result.pixels.push_back(value);
    }
  }
  return result;
}

}  // namespace

std::vector<Plane> UpsampleAlongEdges(const std::vector<Plane>& small,
                                      const ColorImage& color,
                                      const DepthImage& depth) {
  std::vector<Plane> results;
  if (small.empty()) return results;
  Guides full_guides, small_guides;
  MakeGuides(color, depth, cv::Size(small[0].width, small[0].height), &full_guides, &small_guides);
  const WindowFits fits(small_guides);
  for (const Plane& plane : small) {
    const cv::Mat values(
        plane.height, plane.width, CV_32F, const_cast<float*>(plane.pixels.data()));
    results.push_back(Apply(fits.Fit(values), full_guides));
  }
  return results;
}

}  // namespace nightmap
