// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/true_things.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

namespace nightmap {

namespace {

Eigen::Matrix3d BuildingFromBox(const Box& box) {
  return Eigen::AngleAxisd(box.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

// The smallest box with the axes of the largest part that holds all parts.
Box BoxAround(const std::vector<Box>& parts) {
  Box around =
      *std::ranges::max_element(parts, {}, [](const Box& part) { return part.half_size.prod(); });
  const Eigen::Matrix3d building_from_around = BuildingFromBox(around);
  Eigen::AlignedBox3d extent;  // about the largest part's centre, in its axes
  for (const Box& part : parts) {
    const Eigen::Matrix3d around_from_part =
        building_from_around.transpose() * BuildingFromBox(part);
    const Eigen::Vector3d center = building_from_around.transpose() * (part.center - around.center);
    const Eigen::Vector3d reach = around_from_part.cwiseAbs() * part.half_size;
    extent.extend(center - reach);
    extent.extend(center + reach);
  }
  around.center += building_from_around * extent.center();
  around.half_size = extent.sizes() / 2;
  return around;
}

}  // namespace

bool IsThingLabel(SurfaceLabel label) {
  return std::ranges::find(kThingLabels, label) != kThingLabels.end();
}

std::vector<Box> TrueThings(const std::vector<Box>& boxes) {
  std::map<std::pair<int, SurfaceLabel>, std::vector<Box>> parts;
  for (const Box& box : boxes) {
    if (box.piece_idx >= 0 && IsThingLabel(box.label)) {
      parts[{box.piece_idx, box.label}].push_back(box);
    }
  }
  std::vector<Box> things;
  for (const auto& [thing, parts_of_it] : parts) things.push_back(BoxAround(parts_of_it));
  return things;
}

}  // namespace nightmap
