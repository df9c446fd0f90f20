// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/fixed_parts.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace nightmap {
namespace {

// Views are compared in cells of this size, which have little noise.
constexpr int kViewCell_px = 8;
constexpr double kMeanLevel = 110;            // that exposure is reduced to
constexpr double kOtherLevel = 12;            // a cell that differs by more shows something else
constexpr double kOtherShare = 0.2;           // of cells: another view
constexpr std::size_t kMaxSummedViews = 100;  // evenly spread ones; more tell no more
// Gradients below this, in gray levels per pixel, are noise; they count less.
constexpr double kNoiseGradient = 2;
constexpr double kLeastGradient = 1e-6;  // keeps 0 / 0 away
// Length of the mean of the views' unit gradients: 1 where all are alike, about 1 / sqrt(views)
// where they are not.
constexpr double kAlike = 0.75;
// Likewise for axes, which an outline keeps whether the world behind it is brighter or darker.
constexpr double kAlikeAxes = 0.6;
// Deviation of the gray level over the views, in medians over the picture.
constexpr double kSteadyRatio = 0.25;
constexpr int kGap_px = 3;  // that is closed; what is thinner than twice that is no part
constexpr double kMinPartShare = 0.003;  // of the picture
constexpr double kMinEdgeShare = 0.5;    // of a part's outline in the picture
constexpr double kTexturedShare = 0.4;   // of a part's pixels, which then needs no outline

cv::Mat MatOf(const GrayImage& gray) {
  // OpenCV takes no const pixels; nothing here writes them.
  return {gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data())};
}

// A small copy of one mean gray level.
cv::Mat CellsOf(const GrayImage& picture) {
  cv::Mat cells;
  const cv::Size size(std::max(1, picture.width / kViewCell_px),
                      std::max(1, picture.height / kViewCell_px));
  cv::resize(MatOf(picture), cells, size, 0, 0, cv::INTER_AREA);
  cells.convertTo(cells, CV_8UC1, kMeanLevel / std::max(1.0, cv::mean(cells)[0]));
  return cells;
}

bool IsSameView(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  const int num_other = cv::countNonZero(difference > kOtherLevel);
  return num_other <= kOtherShare * static_cast<double>(difference.total());
}

// Indices of pictures of which none shows the view of another.
std::vector<std::size_t> ChooseViews(const std::vector<GrayImage>& pictures) {
  std::vector<std::size_t> chosen;
  std::vector<cv::Mat> views;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const cv::Mat cells = CellsOf(pictures[i]);
    const auto is_same = [&](const cv::Mat& view) { return IsSameView(view, cells); };
    if (std::ranges::any_of(views, is_same)) continue;
    chosen.push_back(i);
    views.push_back(cells);
  }
  return chosen;
}

// Sums over views, per pixel.
class ViewSums {
 public:
  explicit ViewSums(cv::Size size) {
    for (cv::Mat* sum : {&x_, &y_, &axis_x_, &axis_y_, &gray_, &square_})
      *sum = cv::Mat::zeros(size, CV_32FC1);
  }

  void Add(const GrayImage& picture) {
    cv::Mat gray, x, y, length;
    cv::GaussianBlur(MatOf(picture), gray, {0, 0}, 1);
    gray.convertTo(gray, CV_32FC1);
    cv::Sobel(gray, x, CV_32FC1, 1, 0, 3, 1.0 / 8);
    cv::Sobel(gray, y, CV_32FC1, 0, 1, 3, 1.0 / 8);
    cv::magnitude(x, y, length);
    const cv::Mat weighted = length + kNoiseGradient;
    x_ += x / weighted;
    y_ += y / weighted;
    // The double angle of an axis is the same for both of its directions.
    const cv::Mat squared = weighted.mul(length + kLeastGradient);
    axis_x_ += (x.mul(x) - y.mul(y)) / squared;
    axis_y_ += 2 * x.mul(y) / squared;
    gray_ += gray;
    square_ += gray.mul(gray);
    ++count_;
  }

  // Not 0 where the gradients are alike.
  cv::Mat AlikeEdges() const {
    cv::Mat length;
    cv::magnitude(x_, y_, length);
    return length > kAlike * count_;
  }

  // Not 0 where the axes of the gradients are alike.
  cv::Mat AlikeAxes() const {
    cv::Mat length;
    cv::magnitude(axis_x_, axis_y_, length);
    return length > kAlikeAxes * count_;
  }

  // Not 0 where the gray level hardly varies.
  cv::Mat Steady() const {
    const cv::Mat mean = gray_ / count_;
    cv::Mat deviation = cv::max(square_ / count_ - mean.mul(mean), 0.0);
    cv::sqrt(deviation, deviation);
    std::vector<float> sorted(deviation.begin<float>(), deviation.end<float>());
    const auto middle = sorted.begin() + std::ssize(sorted) / 2;
    std::ranges::nth_element(sorted, middle);
    return deviation < kSteadyRatio * *middle;
  }

 private:
  cv::Mat x_, y_, axis_x_, axis_y_, gray_, square_;
  double count_ = 0;
};

cv::Mat Disk(int radius_px) {
  const int size = 2 * radius_px + 1;
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size});
}

// Without gaps and thin lines. The outside of the picture is as at its border.
cv::Mat Smoothed(const cv::Mat& pixels) {
  constexpr int kAround_px = 3 * kGap_px;
  cv::Mat wide;
  cv::copyMakeBorder(
      pixels, wide, kAround_px, kAround_px, kAround_px, kAround_px, cv::BORDER_REPLICATE);
  cv::morphologyEx(wide, wide, cv::MORPH_CLOSE, Disk(kGap_px));
  cv::morphologyEx(wide, wide, cv::MORPH_OPEN, Disk(kGap_px));
  return wide({kAround_px, kAround_px, pixels.cols, pixels.rows}).clone();
}

double NumOf(const cv::Mat& pixels) { return cv::countNonZero(pixels); }

// Whether the part's texture stays, or edges along its outline do. The picture's frame is none.
bool HasEdges(const cv::Mat& part, const cv::Mat& edges, const cv::Mat& axes) {
  if (NumOf(part & edges) > kTexturedShare * NumOf(part)) return true;
  cv::Mat inner, near;
  cv::erode(part, inner, Disk(1), {-1, -1}, 1, cv::BORDER_REPLICATE);
  cv::dilate(axes, near, Disk(kGap_px));
  const cv::Mat outline = part & ~inner;
  return NumOf(outline & near) > kMinEdgeShare * NumOf(outline);
}

cv::Mat FindParts(const ViewSums& sums) {
  const cv::Mat edges = sums.AlikeEdges(), axes = sums.AlikeAxes();
  cv::Mat labels, kept = cv::Mat::zeros(edges.size(), CV_8UC1);
  const int num_labels = cv::connectedComponents(Smoothed(edges | sums.Steady()), labels);
  for (int label = 1; label < num_labels; ++label) {
    const cv::Mat part = labels == label;
    if (NumOf(part) < kMinPartShare * static_cast<double>(part.total())) continue;
    if (HasEdges(part, edges, axes)) kept |= part;
  }
  return kept;
}

GrayImage ToImage(const cv::Mat& pixels) {
  return {pixels.cols, pixels.rows, 1, {pixels.begin<std::uint8_t>(), pixels.end<std::uint8_t>()}};
}

}  // namespace

FixedParts FindFixedParts(const std::vector<GrayImage>& pictures) {
  const auto views = ChooseViews(pictures);
  FixedParts parts{views.size(), {}};
  if (views.size() < kMinViews) return parts;
  ViewSums sums({pictures.front().width, pictures.front().height});
  const std::size_t num_summed = std::min(views.size(), kMaxSummedViews);
  for (std::size_t i = 0; i < num_summed; ++i)
    sums.Add(pictures[views[i * views.size() / num_summed]]);
  const cv::Mat kept = FindParts(sums);
  const double share = NumOf(kept) / static_cast<double>(kept.total());
  if (share > 0 && share <= kMaxFixedShare) parts.mask = ToImage(kept);
  return parts;
}

GrayImage EnlargeMask(const GrayImage& mask, int width, int height, int margin_px) {
  cv::Mat enlarged;
  cv::dilate(MatOf(mask), enlarged, Disk(margin_px));
  cv::resize(enlarged, enlarged, {width, height}, 0, 0, cv::INTER_NEAREST);
  return ToImage(enlarged);
}

}  // namespace nightmap
