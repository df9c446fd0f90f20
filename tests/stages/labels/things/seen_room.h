// SPDX-License-Identifier: Apache-2.0
// A room of solid boxes, and what cameras with depth see of it: octree and labelled voxels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "pipeline/geometry/voxel_key.h"
#include "stages/labels/things/things.h"

namespace nightmap {

constexpr std::uint8_t kWall = 1, kFloor = 2, kSofa = 3, kCabinet = 4;

struct Solid {
  std::uint8_t label = 0;
  Rigid2 map_from_solid;  // the origin is the footprint's centre
  double bottom_m = 0;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();

  // Distance along a ray to its first point in the solid; nothing when it misses.
  std::optional<double> Hit(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
    const Rigid3 solid_from_map = Rigid3{
        map_from_solid.ToRigid3().rotation,
        {map_from_solid.translation.x(),
         map_from_solid.translation.y(),
         bottom_m + size_m.z() / 2}}.Inverse();
    const Eigen::Vector3d start = solid_from_map * from;
    const Eigen::Vector3d way = solid_from_map.rotation * direction;
    double near = 0, far = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (-size_m[axis] / 2 - start[axis]) / way[axis];
      const double b = (size_m[axis] / 2 - start[axis]) / way[axis];
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    }
    if (near >= far) return {};
    return near;
  }
};

// Looks from a place to another, upright.
inline Rigid3 LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d z = (to - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return {Eigen::Quaterniond(axes), from};
}

class SeenRoom {
 public:
  explicit SeenRoom(double resolution_m = 0.05) : resolution_m_(resolution_m) {}

  std::vector<Solid> solids;
  std::vector<Rigid3> cameras;  // map_from_camera

  ThingsInputs Inputs() const {
    ThingsInputs inputs;
    RgbdCamera camera;
    camera.camera_id = "front";
    camera.color = {160, 120, 110, 110, 79.5, 59.5};
    inputs.cameras = {camera};
    Voxels voxels;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      Keyframe& keyframe = inputs.keyframes.emplace_back();
      keyframe.keyframe_idx = static_cast<int>(i);
      keyframe.frame.time_ns = 1000 + static_cast<std::int64_t>(i);
      keyframe.frame.color.path = std::to_string(i) + ".png";
      keyframe.map_from_camera = cameras[i];
      See(cameras[i], camera.color, &voxels);
    }
    inputs.voxels = LabelsOf(voxels);
    inputs.leaves = LeavesOfTree(TreeOf(voxels));
    return inputs;
  }

 private:
  struct Voxel {
    std::map<std::uint8_t, int> hits;
  };
  using Voxels = std::unordered_map<std::uint64_t, Voxel>;

  void See(const Rigid3& map_from_camera, const Camera& camera, Voxels* voxels) const {
    constexpr double kReach_m = 4.5;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector3d direction =
            map_from_camera.rotation *
            camera.BackProject({static_cast<double>(u), static_cast<double>(v)}, 1).normalized();
        double end_m = kReach_m;
        const Solid* hit = nullptr;
        for (const Solid& solid : solids) {
          const auto at_m = solid.Hit(map_from_camera.translation, direction);
          if (!at_m || *at_m >= end_m) continue;
          end_m = *at_m;
          hit = &solid;
        }
        const auto key_at = [&](double at_m) {
          return PackVoxel(VoxelOf(map_from_camera.translation + at_m * direction, resolution_m_));
        };
        std::uint64_t last = 0;
        for (double at_m = 0; at_m < end_m; at_m += resolution_m_ / 2) {
          const std::uint64_t key = key_at(at_m);
          if (key != last) voxels->try_emplace(key);
          last = key;
        }
        if (hit) ++(*voxels)[key_at(end_m + 1e-6)].hits[hit->label];
      }
    }
  }

  VoxelLabels LabelsOf(const Voxels& voxels) const {
    std::map<std::uint64_t, const Voxel*> by_code;
    for (const auto& [packed, voxel] : voxels) {
      if (!voxel.hits.empty()) by_code[MortonCode(UnpackVoxel(packed))] = &voxel;
    }
    VoxelLabels labels;
    labels.resolution_m = resolution_m_;
    labels.classes = {"none", "wall", "floor", "sofa", "cabinet"};
    for (const auto& [code, voxel] : by_code) {
      labels.keys.push_back(KeyOfMortonCode(code));
      labels.num_views.push_back(1);
      for (const auto& [label, count] : voxel->hits) {
        labels.vote_labels.push_back(label);
        labels.vote_weights.push_back(static_cast<float>(count));
      }
      labels.vote_offsets.push_back(labels.vote_labels.size());
    }
    return labels;
  }

  OccupancyTree TreeOf(const Voxels& voxels) const {
    OccupancyTree tree{resolution_m_, {}};
    for (const auto& [packed, voxel] : voxels) {
      OccupancyVoxel& leaf = tree.leaves.emplace_back();
      leaf.centre_in_map = VoxelCentre(UnpackVoxel(packed), resolution_m_);
      leaf.size_m = resolution_m_;
      leaf.log_odds = voxel.hits.empty() ? -1 : 1;
    }
    return tree;
  }

  double resolution_m_;
};

// Share of the union of two boxes that both have.
inline double IntersectionOverUnion(const Thing& thing, const Solid& solid) {
  constexpr int kSteps = 40;
  int num_inside = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Array3d share =
        (Eigen::Array3d(i % kSteps, i / kSteps % kSteps, i / kSteps / kSteps) + 0.5) / kSteps - 0.5;
    const Eigen::Vector3d in_solid = share * solid.size_m.array();
    const Eigen::Vector2d in_thing = thing.map_from_thing.Inverse() *
                                     (solid.map_from_solid * Eigen::Vector2d(in_solid.head<2>()));
    const double z_m = solid.bottom_m + solid.size_m.z() / 2 + in_solid.z() - thing.bottom_m;
    num_inside += (2 * in_thing.cwiseAbs().array() <= thing.size_m.head<2>().array()).all() &&
                  z_m >= 0 && z_m <= thing.size_m.z();
  }
  const double common = solid.size_m.prod() * num_inside / (kSteps * kSteps * kSteps);
  return common / (solid.size_m.prod() + thing.size_m.prod() - common);
}

}  // namespace nightmap
