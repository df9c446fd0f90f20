// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/submap_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace nightmap {
namespace {

constexpr int kSubpixelBits = 4;

struct BeamEnd {
  Eigen::Vector2d point;
  bool is_boundary = false;
};

// Beam after beam, in the frame of the map's axes about the robot. Beams that hit nothing end at
// the laser.
std::vector<BeamEnd> EndsOf(const QueryScan& scan, double heading_rad, double max_range_m) {
  const Rigid2 axes_from_laser = Rigid2{heading_rad, {0, 0}} * scan.query_from_laser;
  std::vector<BeamEnd> ends;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = scan.IsHit(i) ? scan.ranges_m[i] : 0;
    const double angle_rad = axes_from_laser.heading_rad + scan.Angle_rad(i);
    const Eigen::Vector2d beam(std::cos(angle_rad), std::sin(angle_rad));
    ends.push_back({axes_from_laser.translation + std::min(range_m, max_range_m) * beam,
                    range_m > 0 && range_m <= max_range_m});
  }
  return ends;
}

SubmapImage EmptyImage(double resolution_m,
                       const Eigen::Vector2d& low,
                       const Eigen::Vector2d& high) {
  const Eigen::Vector2i size =
      ((high - low) / resolution_m).array().ceil().cast<int>().max(1).matrix();
  SubmapImage submap{{size.x(), size.y(), 1, {}}, resolution_m, low};
  submap.image.pixels.assign(
      static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()), kNonFreePixel);
  return submap;
}

// The picture that the ends fit in. The robot is at the middle of a pixel.
SubmapImage ImageAround(const std::vector<std::vector<BeamEnd>>& scans, double resolution_m) {
  Eigen::Vector2d low(0, 0), high(0, 0);
  for (const auto& ends : scans) {
    for (const BeamEnd& end : ends) {
      low = low.cwiseMin(end.point);
      high = high.cwiseMax(end.point);
    }
  }
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(resolution_m / 2);
  const Eigen::Vector2d first = ((low + half) / resolution_m).array().floor() * resolution_m;
  return EmptyImage(resolution_m, first - half, high + half);
}

void FillFree(const std::vector<BeamEnd>& ends, const Eigen::Vector2d& laser, SubmapImage* submap) {
  const auto to_subpixels = [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2d pixel =
        ((point - submap->origin) / submap->resolution_m).array() - 0.5;  // OpenCV's centres
    return cv::Point(static_cast<int>(std::lround(pixel.x() * (1 << kSubpixelBits))),
                     static_cast<int>(std::lround(pixel.y() * (1 << kSubpixelBits))));
  };
  std::vector<cv::Point> outline{to_subpixels(laser)};
  for (const BeamEnd& end : ends) outline.push_back(to_subpixels(end.point));
  cv::Mat pixels(submap->image.height, submap->image.width, CV_8U, submap->image.pixels.data());
  cv::fillPoly(pixels,
               std::vector<std::vector<cv::Point>>{outline},
               cv::Scalar(kFreePixel),
               cv::LINE_8,
               kSubpixelBits);
}

// Columns and rows of the grid that meet the box from low to high: [first, end).
std::pair<Eigen::Vector2i, Eigen::Vector2i> CellsIn(const OccupancyGrid& grid,
                                                    const Eigen::Vector2d& low,
                                                    const Eigen::Vector2d& high) {
  Eigen::Vector2d first = grid.ToCells(low), end = first;
  for (const Eigen::Vector2d& corner :
       {high, Eigen::Vector2d(low.x(), high.y()), Eigen::Vector2d(high.x(), low.y())}) {
    first = first.cwiseMin(grid.ToCells(corner));
    end = end.cwiseMax(grid.ToCells(corner));
  }
  const Eigen::Vector2i size(grid.width, grid.height), none(0, 0);
  return {first.array().floor().cast<int>().matrix().cwiseMax(none),
          end.array().ceil().cast<int>().matrix().cwiseMin(size)};
}

}  // namespace

SubmapImage ImageOfSubmap(const ScanQuery& query,
                          double heading_rad,
                          double resolution_m,
                          double max_range_m) {
  std::vector<std::vector<BeamEnd>> scans;
  for (const QueryScan& scan : query.scans) {
    scans.push_back(EndsOf(scan, heading_rad, max_range_m));
  }
  SubmapImage submap = ImageAround(scans, resolution_m);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Eigen::Vector2d laser =
        Rigid2{heading_rad, {0, 0}} * query.scans[i].query_from_laser.translation;
    FillFree(scans[i], laser, &submap);
  }
  for (const auto& ends : scans) {
    for (const BeamEnd& end : ends) {
      if (!end.is_boundary) continue;
      const Eigen::Vector2i pixel = submap.PixelOf(end.point);
      submap.image.At(std::min(pixel.x(), submap.image.width - 1),
                      std::min(pixel.y(), submap.image.height - 1)) = kBoundaryPixel;
    }
  }
  return submap;
}

SubmapImage ImageOfMap(const OccupancyGrid& grid,
                       double resolution_m,
                       const Eigen::Vector2d& low,
                       const Eigen::Vector2d& high) {
  SubmapImage map = EmptyImage(resolution_m, low, high);
  const auto [first, end] = CellsIn(grid, low, high);
  for (int y = first.y(); y < end.y(); ++y) {
    for (int x = first.x(); x < end.x(); ++x) {
      const std::uint8_t cell = grid.At({x, y});
      const Eigen::Vector2i pixel = map.PixelOf(grid.CenterInMap({x, y}));
      if (cell == kUnknownCell || pixel.minCoeff() < 0 || pixel.x() >= map.image.width ||
          pixel.y() >= map.image.height) {
        continue;
      }
      std::uint8_t& value = map.image.At(pixel.x(), pixel.y());
      if (cell == kOccupiedCell) value = kBoundaryPixel;
      if (cell == kFreeCell && value == kNonFreePixel) value = kFreePixel;
    }
  }
  return map;
}

}  // namespace nightmap
