// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "stages/plan/path_output.h"

namespace nightmap {
namespace {

constexpr int kTargetSide_px = 1200;  // the longer side is enlarged to at most this
constexpr int kMaxScale = 12;
constexpr int kShift = 4;  // OpenCV draws in 1/16 px
// RGB, the order of ColorImage.
const cv::Scalar kTrajectory(225, 190, 140);
const cv::Scalar kSwath(190, 215, 245);
const cv::Scalar kLine(20, 80, 200);
const cv::Scalar kStart(20, 150, 60);
const cv::Scalar kGoal(210, 40, 40);
const cv::Scalar kInk(30, 30, 30);
const cv::Scalar kPaper(255, 255, 255);

class Canvas {
 public:
  explicit Canvas(const OccupancyGrid& grid)
      : grid_(grid),
        scale_(std::clamp(kTargetSide_px / std::max(grid.width, grid.height), 1, kMaxScale)),
        image_{grid.width * scale_, grid.height * scale_, 3, {}} {
    image_.pixels.resize(static_cast<std::size_t>(image_.width) *
                         static_cast<std::size_t>(image_.height) * 3);
    mat_ = cv::Mat(image_.height, image_.width, CV_8UC3, image_.pixels.data());
    thickness_ = std::max(1, std::max(image_.width, image_.height) / 400);
  }

  void DrawCells() {
    const cv::Vec3b gray[] = {{255, 255, 255}, {40, 40, 40}, {205, 205, 205}};
    for (int y = 0; y < mat_.rows; ++y) {
      for (int x = 0; x < mat_.cols; ++x) {
        const Eigen::Vector2i cell(x / scale_, (mat_.rows - 1 - y) / scale_);
        mat_.at<cv::Vec3b>(y, x) = gray[std::min<int>(grid_.At(cell), 2)];
      }
    }
  }

  // Tints only what is free, so that a swath never hides an obstacle.
  void DrawSwath(const std::vector<PathPoint>& path, double radius_m) {
    cv::Mat mask = cv::Mat::zeros(mat_.size(), CV_8U);
    const int radius = Fixed(radius_m / grid_.resolution_m * scale_);
    for (const PathPoint& point : path) {
      cv::circle(mask, ToPixel(point.point_in_map), radius, 255, cv::FILLED, cv::LINE_8, kShift);
    }
    cv::Mat free;
    cv::inRange(mat_, kPaper, kPaper, free);
    mat_.setTo(kSwath, mask & free);
  }

  void DrawLine(const std::vector<Eigen::Vector2d>& points,
                const cv::Scalar& color,
                int thickness) {
    for (std::size_t i = 1; i < points.size(); ++i) {
      cv::line(
          mat_, ToPixel(points[i - 1]), ToPixel(points[i]), color, thickness, cv::LINE_AA, kShift);
    }
  }

  // The robot's outline as it stands at a path point.
  void DrawOutline(const std::vector<Eigen::Vector2d>& corners, const PathPoint& point) {
    std::vector<Eigen::Vector2d> outline;
    for (const Eigen::Vector2d& corner : corners) {
      outline.push_back(point.point_in_map + Eigen::Rotation2Dd(point.heading_rad) * corner);
    }
    if (!outline.empty()) outline.push_back(outline.front());
    DrawLine(outline, kInk, 1);
  }

  void DrawEnd(const Endpoint& endpoint, const std::string& label, const cv::Scalar& color) {
    const int radius = std::max(4, 2 * thickness_);
    const cv::Point pixel = ToPixel(endpoint.point_in_map);
    if (endpoint.moved_by_m > 0) {
      const cv::Point asked = ToPixel(endpoint.request.point_in_map);
      cv::line(mat_, asked, pixel, color, 1, cv::LINE_AA, kShift);
      cv::circle(mat_, asked, Fixed(radius), color, 1, cv::LINE_AA, kShift);
    }
    cv::circle(mat_, pixel, Fixed(radius), color, cv::FILLED, cv::LINE_AA, kShift);
    Write(label, {pixel.x / 16 + radius + 3, pixel.y / 16 - radius - 2}, color);
  }

  // The longest of 1, 2, 5, 10, 20, 50 m that takes at most a quarter of the width.
  void DrawScaleBar() {
    const double pixels_per_m = scale_ / grid_.resolution_m;
    int length_m = 1;
    for (const int candidate_m : {2, 5, 10, 20, 50}) {
      if (candidate_m * pixels_per_m <= mat_.cols / 4.0) length_m = candidate_m;
    }
    const int length = static_cast<int>(std::lround(length_m * pixels_per_m));
    const cv::Point left(8, mat_.rows - 8);
    cv::line(mat_, left, left + cv::Point(length, 0), kInk, 3);
    Write(std::to_string(length_m) + " m", left + cv::Point(0, -8), kInk);
  }

  int Thickness() const { return thickness_; }
  ColorImage Take() { return std::move(image_); }

 private:
  static int Fixed(double pixels) { return static_cast<int>(std::lround(pixels * (1 << kShift))); }

  cv::Point ToPixel(const Eigen::Vector2d& point_in_map) const {
    const Eigen::Vector2d cells = grid_.ToCells(point_in_map) * scale_;
    const Eigen::Vector2d pixel(std::clamp(cells.x(), -1e6, 1e6),
                                std::clamp(mat_.rows - cells.y(), -1e6, 1e6));
    return {Fixed(pixel.x() - 0.5), Fixed(pixel.y() - 0.5)};
  }

  // Kept inside of the image; a white rim makes it legible on any ground.
  void Write(const std::string& text, cv::Point corner, const cv::Scalar& color) {
    const double size = std::clamp(std::max(mat_.cols, mat_.rows) / 1600.0, 0.45, 1.0);
    int baseline = 0;
    const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 2, &baseline);
    corner.x = std::clamp(corner.x, 2, std::max(2, mat_.cols - box.width - 2));
    corner.y = std::clamp(corner.y, box.height + 2, std::max(box.height + 2, mat_.rows - 4));
    cv::putText(mat_, text, corner, cv::FONT_HERSHEY_SIMPLEX, size, kPaper, 4, cv::LINE_AA);
    cv::putText(mat_, text, corner, cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
  }

  const OccupancyGrid& grid_;
  int scale_;  // pixels a cell
  int thickness_ = 1;
  ColorImage image_;
  cv::Mat mat_;  // the same pixels
};

}  // namespace

ColorImage DrawPath(const PlanInputs& inputs,
                    const PlanResult& result,
                    const FootprintOptions& footprint) {
  Canvas canvas(inputs.grid);
  canvas.DrawCells();
  canvas.DrawSwath(result.path, CircumscribedRadius_m(footprint));
  std::vector<Eigen::Vector2d> travelled;
  for (const StampedPose& pose : inputs.trajectory) {
    travelled.push_back(pose.pose.translation.head<2>());
  }
  canvas.DrawLine(travelled, kTrajectory, 1);
  std::vector<Eigen::Vector2d> path;
  for (const PathPoint& point : result.path) path.push_back(point.point_in_map);
  canvas.DrawLine(path, kLine, canvas.Thickness());
  const auto corners = FootprintCorners(footprint);
  canvas.DrawOutline(corners, result.path.front());
  for (const PlanLeg& leg : result.legs) canvas.DrawOutline(corners, result.path[leg.last_point]);
  canvas.DrawEnd(result.ends.front(), "start", kStart);
  for (std::size_t i = 1; i < result.ends.size(); ++i) {
    canvas.DrawEnd(result.ends[i], result.ends[i].request.role, kGoal);
  }
  canvas.DrawScaleBar();
  return canvas.Take();
}

}  // namespace nightmap
