// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "stages/drive/drive_output.h"

namespace nightmap {
namespace {

constexpr double kTargetSide_px = 360;
constexpr int kFixedShift = 4;  // OpenCV draws in 1/16 px
// RGB, the order of ColorImage. Without anti-aliasing: a GIF has few colors.
const cv::Scalar kPathColor(130, 170, 230);
const cv::Scalar kDrivenColor(20, 80, 200);
const cv::Scalar kRobotColor(20, 150, 60);
const cv::Scalar kHeadingColor(255, 255, 255);
const cv::Scalar kGoalColor(210, 40, 40);
const cv::Vec3b kCellColors[] = {{255, 255, 255}, {40, 40, 40}, {205, 205, 205}};

cv::Mat MatOf(ColorImage& image) {
  return {image.height, image.width, CV_8UC3, image.pixels.data()};
}

class DriveCanvas {
 public:
  explicit DriveCanvas(const OccupancyGrid& grid)
      : grid_(grid), scale_(kTargetSide_px / std::max(grid.width, grid.height)) {
    image_ = {Side(grid.width), Side(grid.height), 3, {}};
    image_.pixels.resize(static_cast<std::size_t>(image_.width) *
                         static_cast<std::size_t>(image_.height) * 3);
    cv::Mat mat = MatOf(image_);
    for (int y = 0; y < mat.rows; ++y) {
      for (int x = 0; x < mat.cols; ++x) mat.at<cv::Vec3b>(y, x) = kCellColors[CellAt(x, y)];
    }
  }

  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const cv::Scalar& color) {
    cv::line(MatOf(image_), Pixel(from), Pixel(to), color, 1, cv::LINE_8, kFixedShift);
  }
  void Disc(const Eigen::Vector2d& center, double radius_m, const cv::Scalar& color) {
    const double radius_px = std::max(2.0, radius_m / grid_.resolution_m * scale_);
    cv::circle(
        MatOf(image_), Pixel(center), Fixed(radius_px), color, cv::FILLED, cv::LINE_8, kFixedShift);
  }
  const ColorImage& Image() const { return image_; }

 private:
  static int Fixed(double pixels) {
    return static_cast<int>(std::lround(std::clamp(pixels, -1e6, 1e6) * (1 << kFixedShift)));
  }
  int Side(int cells) const { return std::max(1, static_cast<int>(std::lround(cells * scale_))); }
  // An obstacle shows however many cells a pixel stands for.
  int CellAt(int x, int y) const {
    const auto range = [&](int pixel, int num_cells) {
      const int first = std::min(static_cast<int>(pixel / scale_), num_cells - 1);
      const int end = static_cast<int>(std::ceil((pixel + 1) / scale_));
      return std::pair(first, scale_ >= 1 ? first + 1 : std::clamp(end, first + 1, num_cells));
    };
    const auto [first_x, end_x] = range(x, grid_.width);
    const auto [first_y, end_y] = range(image_.height - 1 - y, grid_.height);
    int value = grid_.At({first_x, first_y});
    for (int cell_y = first_y; cell_y < end_y; ++cell_y) {
      for (int cell_x = first_x; cell_x < end_x; ++cell_x) {
        if (grid_.At({cell_x, cell_y}) == kOccupiedCell) return kOccupiedCell;
      }
    }
    return std::min<int>(value, kUnknownCell);
  }
  cv::Point Pixel(const Eigen::Vector2d& point_in_map) const {
    const Eigen::Vector2d pixel = grid_.ToCells(point_in_map) * scale_;
    return {Fixed(pixel.x() - 0.5), Fixed(image_.height - pixel.y() - 0.5)};
  }

  const OccupancyGrid& grid_;
  double scale_;  // pixels a cell
  ColorImage image_;
};

void DrawRobot(DriveCanvas& canvas, const PlanarPose& pose, double radius_m) {
  const Eigen::Vector2d ahead(std::cos(pose.heading_rad), std::sin(pose.heading_rad));
  canvas.Disc(pose.point_in_map, radius_m, kRobotColor);
  canvas.Line(pose.point_in_map, pose.point_in_map + radius_m * ahead, kHeadingColor);
}

}  // namespace

std::vector<ColorImage> DrawDrive(const DriveInputs& inputs, const DriveResult& result) {
  DriveCanvas driven(inputs.grid);
  for (const auto& leg : inputs.path.legs_in_map) {
    for (std::size_t i = 1; i < leg.size(); ++i) driven.Line(leg[i - 1], leg[i], kPathColor);
    driven.Disc(leg.back(), 0.5 * result.footprint.radius_m, kGoalColor);
  }

  std::vector<ColorImage> images;
  const std::size_t last = result.steps.size() - 1;
  const std::size_t stride =
      std::max<std::size_t>(1, (last + kMaxDriveImages - 2) / (kMaxDriveImages - 1));
  for (std::size_t i = 0; i <= last; ++i) {
    const PlanarPose& pose = result.steps[i].pose;
    if (i > 0) driven.Line(result.steps[i - 1].pose.point_in_map, pose.point_in_map, kDrivenColor);
    if (i % stride != 0 && i != last) continue;
    DriveCanvas canvas = driven;
    DrawRobot(canvas, pose, result.footprint.radius_m);
    images.push_back(canvas.Image());
  }
  return images;
}

}  // namespace nightmap
