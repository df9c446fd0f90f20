// SPDX-License-Identifier: Apache-2.0
// Camera::Undistort and RegisterDepth against OpenCV's.
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/rgbd/depth.hpp>

#include "pipeline/io/resize_picture.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"
#include "tests/bench/libraries/to_opencv.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumFrames = 8;

cv::Mat Distortion(const Camera& camera) {
  return (cv::Mat_<double>(1, 5) << camera.k1, camera.k2, camera.p1, camera.p2, camera.k3);
}

// How far a point that was undistorted is from the pixel it came from.
double RoundTrip_px(const Camera& camera, const cv::Point2d& undistorted, const cv::Point2d& from) {
  const auto back =
      camera.Project(camera.BackProjectUndistorted({undistorted.x, undistorted.y}, 1));
  return back ? (*back - Eigen::Vector2d(from.x, from.y)).norm() : 0;
}

// OpenCV stops after five iterations, unless it is told another end.
void CompareUndistort(const std::string& name,
                      const Camera& camera,
                      const std::string& other,
                      const cv::TermCriteria& end) {
  std::vector<cv::Point2d> pixels;
  for (int y = 0; y < camera.height; y += 4) {
    for (int x = 0; x < camera.width; x += 4) pixels.emplace_back(x, y);
  }
  std::vector<cv::Point2d> ours(pixels.size());
  std::vector<cv::Point2d> theirs;
  const cv::Mat matrix = CameraMatrix(camera);
  const auto largest_px = [&](const std::vector<cv::Point2d>& undistorted) {
    double largest = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      largest = std::max(largest, RoundTrip_px(camera, undistorted[i], pixels[i]));
    }
    return largest;
  };
  PrintComparison(
      {.ours = "`Camera::Undistort`",
       .other = other,
       .input = fmt::format("{}: {} pixels", name, pixels.size()),
       .run_ours =
           [&](int) {
             for (std::size_t i = 0; i < pixels.size(); ++i) {
               const Eigen::Vector2d point = camera.Undistort({pixels[i].x, pixels[i].y});
               ours[i] = {point.x(), point.y()};
             }
           },
       .run_other =
           [&](int) {
             cv::undistortPoints(
                 pixels, theirs, matrix, Distortion(camera), cv::noArray(), matrix, end);
           },
       .difference =
           [&] {
             return fmt::format("distorted again, at most {:.2g} px and {:.2g} px off",
                                largest_px(ours),
                                largest_px(theirs));
           }});
}

// The recording's depth as if its camera stood 2.5 cm beside a color camera `fineness` times as
// fine.
RgbdCamera BesideEachOther(RgbdCamera camera, int fineness) {
  camera.depth = camera.color;
  camera.depth.k1 = camera.depth.k2 = camera.depth.p1 = camera.depth.p2 = camera.depth.k3 = 0;
  camera.color_from_depth.translation = {0.025, 0, 0};
  camera.color =
      ResizeCamera(camera.color, fineness * camera.color.width, fineness * camera.color.height);
  return camera;
}

std::string DepthDifference(const DepthImage& ours, const cv::Mat& theirs) {
  std::size_t num_ours = 0, num_theirs = 0, num_same = 0;
  for (std::size_t i = 0; i < ours.pixels.size(); ++i) {
    const float a = ours.pixels[i];
    const float b =
        theirs.at<float>(static_cast<int>(i) / ours.width, static_cast<int>(i) % ours.width);
    num_ours += a > 0;
    num_theirs += b > 0;
    num_same += a > 0 && std::abs(a - b) < 0.01F * a;
  }
  const auto percent = [&](std::size_t count) {
    return 100 * static_cast<double>(count) / static_cast<double>(ours.pixels.size());
  };
  return fmt::format("{:.0f} % and {:.0f} % of the pixels have depth, {:.0f} % the same to 1 %",
                     percent(num_ours),
                     percent(num_theirs),
                     percent(num_same));
}

void CompareRegistration(const MappedSite& site, int fineness) {
  const RgbdCamera camera = BesideEachOther(site.cameras[0], fineness);
  std::vector<DepthImage> depths, ours;
  for (const FrameRecord& frame : EvenlySpaced(site.frames, kNumFrames)) {
    depths.push_back(LoadDepth(frame, site.cameras[0], site.data));
  }
  ours.resize(depths.size());
  cv::Mat color_from_depth = cv::Mat::eye(4, 4, CV_64F);
  color_from_depth.at<double>(0, 3) = 0.025;
  cv::Mat theirs;
  PrintComparison({.ours = "`RegisterDepth`",
                   .other = "`cv::rgbd::registerDepth`, dilation",
                   .input = fmt::format("{}: depth image to a color image of {} x {}",
                                        site.name,
                                        camera.color.width,
                                        camera.color.height),
                   .run_ours =
                       [&](int) {
                         for (std::size_t i = 0; i < depths.size(); ++i) {
                           ours[i] = RegisterDepth(depths[i], camera);
                         }
                       },
                   .run_other =
                       [&](int) {
                         for (DepthImage& depth : depths) {
                           const cv::Mat image(
                               depth.height, depth.width, CV_32F, depth.pixels.data());
                           cv::rgbd::registerDepth(CameraMatrix(camera.depth),
                                                   CameraMatrix(camera.color),
                                                   Distortion(camera.color),
                                                   color_from_depth,
                                                   image,
                                                   {camera.color.width, camera.color.height},
                                                   theirs,
                                                   true);
                         }
                       },
                   .difference = [&] { return DepthDifference(ours.back(), theirs); },
                   .num_items = static_cast<double>(depths.size())});
}

}  // namespace

void CompareCameras(const MappedSite& site) {
  const Camera& camera = site.cameras[0].color;
  if (camera.HasDistortion()) {
    const int count = cv::TermCriteria::COUNT;
    CompareUndistort(site.name, camera, "`cv::undistortPoints`", {count, 5, 0});
    CompareUndistort(site.name, camera, "`cv::undistortPoints`, 40 iterations", {count, 40, 0});
  }
  CompareRegistration(site, 1);
  CompareRegistration(site, 3);
}

}  // namespace nightmap
