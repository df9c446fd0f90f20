// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/draw_on_grid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace nightmap {
namespace {

constexpr Rgb kCellColors[] = {{255, 255, 255}, {40, 40, 40}, {205, 205, 205}};  // by CellValue
const cv::Scalar kWhite(255, 255, 255);
constexpr double kFar_px = 1e6;
constexpr int kShift = 4;  // OpenCV draws in 1/16 px

int Fixed(double pixels) {
  return static_cast<int>(std::lround(std::clamp(pixels, -kFar_px, kFar_px) * (1 << kShift)));
}

cv::Point Fixed(const Eigen::Vector2d& pixel) { return {Fixed(pixel.x()), Fixed(pixel.y())}; }

cv::Scalar ToScalar(const Rgb& color) { return {1.0 * color[0], 1.0 * color[1], 1.0 * color[2]}; }

// A view of the same pixels.
cv::Mat ToMat(ColorImage& image) {
  return {image.height, image.width, CV_8UC3, image.pixels.data()};
}

}  // namespace

GridCanvas::GridCanvas(const OccupancyGrid& grid, double pixels_per_cell, bool is_smooth)
    : grid_(grid), scale_(pixels_per_cell), line_type_(is_smooth ? cv::LINE_AA : cv::LINE_8) {
  const auto side = [&](int num_cells) {
    return std::max(1, static_cast<int>(std::lround(num_cells * scale_)));
  };
  image_ = {side(grid.width), side(grid.height), 3, {}};
  for (int y = 0; y < image_.height; ++y) {
    for (int x = 0; x < image_.width; ++x) {
      const Rgb& color = kCellColors[CellAt(x, y)];
      image_.pixels.insert(image_.pixels.end(), color.begin(), color.end());
    }
  }
}

int GridCanvas::CellAt(int x, int y) const {
  const auto range = [&](int pixel, int num_cells) {
    const int first = std::min(static_cast<int>(pixel / scale_), num_cells - 1);
    const int end = static_cast<int>(std::ceil((pixel + 1) / scale_));
    return std::pair(first, scale_ >= 1 ? first + 1 : std::clamp(end, first + 1, num_cells));
  };
  const auto [first_x, end_x] = range(x, grid_.width);
  const auto [first_y, end_y] = range(image_.height - 1 - y, grid_.height);
  for (int cell_y = first_y; cell_y < end_y; ++cell_y) {
    for (int cell_x = first_x; cell_x < end_x; ++cell_x) {
      if (grid_.At({cell_x, cell_y}) == kOccupiedCell) return kOccupiedCell;
    }
  }
  return std::min<int>(grid_.At({first_x, first_y}), kUnknownCell);
}

double GridCanvas::ToPixels(double length_m) const {
  return length_m / grid_.resolution_m * scale_;
}

Eigen::Vector2d GridCanvas::ToPixel(const Eigen::Vector2d& point_in_map) const {
  const Eigen::Vector2d pixel = grid_.ToCells(point_in_map) * scale_;
  return {pixel.x() - 0.5, image_.height - pixel.y() - 0.5};
}

void GridCanvas::Line(const Eigen::Vector2d& from_in_map,
                      const Eigen::Vector2d& to_in_map,
                      const Rgb& color,
                      int thickness_px) {
  const cv::Point from = Fixed(ToPixel(from_in_map));
  const cv::Point to = Fixed(ToPixel(to_in_map));
  cv::line(ToMat(image_), from, to, ToScalar(color), thickness_px, line_type_, kShift);
}

void GridCanvas::Rectangle(const Rigid2& map_from_rectangle,
                           const Eigen::Vector2d& size_m,
                           const Rgb& color,
                           int thickness_px) {
  const auto corner = [&](double x, double y) {
    return map_from_rectangle * Eigen::Vector2d(x * size_m.x() / 2, y * size_m.y() / 2);
  };
  Line(corner(-1, -1), corner(1, -1), color, thickness_px);
  Line(corner(1, -1), corner(1, 1), color, thickness_px);
  Line(corner(1, 1), corner(-1, 1), color, thickness_px);
  Line(corner(-1, 1), corner(-1, -1), color, thickness_px);
}

void GridCanvas::Disc(const Eigen::Vector2d& center_in_map, double radius_px, const Rgb& color) {
  const cv::Point center = Fixed(ToPixel(center_in_map));
  const cv::Scalar ink = ToScalar(color);
  cv::circle(ToMat(image_), center, Fixed(radius_px), ink, cv::FILLED, line_type_, kShift);
}

void GridCanvas::Ring(const Eigen::Vector2d& center_in_map, double radius_px, const Rgb& color) {
  const cv::Point center = Fixed(ToPixel(center_in_map));
  cv::circle(ToMat(image_), center, Fixed(radius_px), ToScalar(color), 1, line_type_, kShift);
}

void GridCanvas::Tint(const std::vector<Eigen::Vector2d>& centers_in_map,
                      double radius_px,
                      const Rgb& color) {
  cv::Mat mask = cv::Mat::zeros(image_.height, image_.width, CV_8U);
  for (const Eigen::Vector2d& center : centers_in_map) {
    const cv::Point pixel = Fixed(ToPixel(center));
    cv::circle(mask, pixel, Fixed(radius_px), 255, cv::FILLED, cv::LINE_8, kShift);
  }
  cv::Mat white;
  cv::inRange(ToMat(image_), kWhite, kWhite, white);
  ToMat(image_).setTo(ToScalar(color), mask & white);
}

void GridCanvas::Label(const Eigen::Vector2d& point_in_map,
                       int right_px,
                       int above_px,
                       const std::string& text,
                       const Rgb& color) {
  const cv::Point pixel = Fixed(ToPixel(point_in_map)) / (1 << kShift);
  Write(text, pixel.x + right_px, pixel.y - above_px, color);
}

void GridCanvas::ScaleBar(const Rgb& color) {
  int length_m = 1;
  for (const int candidate_m : {2, 5, 10, 20, 50}) {
    if (ToPixels(candidate_m) <= image_.width / 4.0) length_m = candidate_m;
  }
  const cv::Point left(8, image_.height - 8);
  const cv::Point right = left + cv::Point(static_cast<int>(std::lround(ToPixels(length_m))), 0);
  cv::line(ToMat(image_), left, right, ToScalar(color), 3);
  Write(std::to_string(length_m) + " m", left.x, left.y - 8, color);
}

// Writes from the text's lower left corner on.
void GridCanvas::Write(const std::string& text, int x, int y, const Rgb& color) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  cv::Mat mat = ToMat(image_);
  const double size = std::clamp(std::max(mat.cols, mat.rows) / 1600.0, 0.45, 1.0);
  int baseline = 0;
  const cv::Size box = cv::getTextSize(text, kFont, size, 2, &baseline);
  const cv::Point corner(std::clamp(x, 2, std::max(2, mat.cols - box.width - 2)),
                         std::clamp(y, box.height + 2, std::max(box.height + 2, mat.rows - 4)));
  cv::putText(mat, text, corner, kFont, size, kWhite, 4, cv::LINE_AA);
  cv::putText(mat, text, corner, kFont, size, ToScalar(color), 1, cv::LINE_AA);
}

}  // namespace nightmap
