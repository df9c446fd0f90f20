// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/true_things.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "pipeline/world/furniture.h"
#include "tests/world/two_floors.h"

namespace nightmap::true_things_test {

using Label = SurfaceLabel;

constexpr double kYaw_rad = 0.7;

// The boxes of one piece, turned by kYaw_rad.
std::vector<Box> BoxesOf(Furniture kind, std::uint64_t seed = 1) {
  SceneBuilder builder(1);
  Random random(seed);
  Piece piece({{3, -2}, kYaw_rad}, builder);
  BuildFurniture(kind, 1.3, random, piece);
  piece.Commit();
  return builder.Boxes();
}

std::vector<Eigen::Vector3d> Corners(const Box& box) {
  std::vector<Eigen::Vector3d> corners;
  const std::array<Surface, 6> faces = BoxFaces(box, Material{});
  for (const Surface& face : {faces[4], faces[5]}) {
    for (const auto& [a, b] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}}) {
      corners.push_back(face.origin + a * face.edge_u + b * face.edge_v);
    }
  }
  return corners;
}

Eigen::Vector3d InBox(const Box& box, const Eigen::Vector3d& point) {
  const double c = std::cos(box.yaw_rad);
  const double s = std::sin(box.yaw_rad);
  const Eigen::Vector3d offset = point - box.center;
  return {c * offset.x() + s * offset.y(), c * offset.y() - s * offset.x(), offset.z()};
}

// The corners of the thing's boxes reach to all its faces, and not beyond.
void ExpectAround(const Box& thing, const std::vector<Box>& boxes) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d high = -low;
  for (const Box& box : boxes) {
    if (box.piece_idx != thing.piece_idx || box.label != thing.label) continue;
    for (const Eigen::Vector3d& corner : Corners(box)) {
      low = low.cwiseMin(InBox(thing, corner));
      high = high.cwiseMax(InBox(thing, corner));
    }
  }
  EXPECT_LT((high - thing.half_size).cwiseAbs().maxCoeff(), 1e-9) << high.transpose();
  EXPECT_LT((low + thing.half_size).cwiseAbs().maxCoeff(), 1e-9) << low.transpose();
}

bool IsParallel(double a_rad, double b_rad) { return std::abs(std::sin(a_rad - b_rad)) < 1e-9; }

TEST(TrueThings, APieceIsAThingPerLabel) {
  const std::map<Furniture, std::vector<Label>> labels = {
      {Furniture::kDesk, {Label::kTable, Label::kChair, Label::kCabinet}},
      {Furniture::kTable, {Label::kTable, Label::kChair}},
      {Furniture::kBed, {Label::kBed}},
      {Furniture::kSofa, {Label::kSofa}},
      {Furniture::kWardrobe, {Label::kCabinet}},
      {Furniture::kCabinet, {Label::kCabinet}},
      {Furniture::kBookshelf, {Label::kShelf}},
      {Furniture::kLowShelf, {Label::kShelf}}};
  for (const auto& [kind, expected] : labels) {
    std::vector<Label> found;
    for (const Box& thing : TrueThings(BoxesOf(kind))) found.push_back(thing.label);
    EXPECT_EQ(found, expected) << static_cast<int>(kind);
  }
}

TEST(TrueThings, HaveTheAxesOfTheirPieceAndAChairItsOwn) {
  int num_turned = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (int kind = 0; kind < 8; ++kind) {
      const std::vector<Box> boxes = BoxesOf(static_cast<Furniture>(kind), seed);
      for (const Box& thing : TrueThings(boxes)) {
        ExpectAround(thing, boxes);
        if (thing.label != Label::kChair) {
          EXPECT_TRUE(IsParallel(thing.yaw_rad, kYaw_rad)) << LabelName(thing.label);
          continue;
        }
        const auto seat = std::ranges::find_if(boxes, [](const Box& box) {
          return box.label == Label::kChair && box.half_size.head<2>().minCoeff() > 0.2;
        });
        ASSERT_NE(seat, boxes.end());
        EXPECT_EQ(thing.yaw_rad, seat->yaw_rad);
        num_turned += IsParallel(thing.yaw_rad, kYaw_rad) ? 0 : 1;
        EXPECT_NEAR(2 * thing.half_size.z(), 0.9, 1e-9);
      }
    }
  }
  EXPECT_EQ(num_turned, 40);
}

TEST(TrueThings, ABoxOfNoPieceIsNoThing) {
  std::vector<Box> boxes = BoxesOf(Furniture::kSofa);
  for (Box& box : boxes) box.piece_idx = -1;
  EXPECT_TRUE(TrueThings(boxes).empty());
}

TEST(TrueThings, AreCountedOverBothFloors) {
  const Scene& scene = TwoFloorWorld().scene;
  const double storey_m = TwoFloorWorld().layout.storey_m;
  std::map<int, std::set<bool>> floors_of_pieces;
  for (const Box& box : scene.boxes) {
    const bool has_piece = box.label != Label::kWall;
    EXPECT_EQ(box.piece_idx >= 0, has_piece) << LabelName(box.label);
    if (has_piece) floors_of_pieces[box.piece_idx].insert(box.center.z() > storey_m);
  }
  ASSERT_EQ(static_cast<int>(floors_of_pieces.size()), scene.num_pieces);
  EXPECT_EQ(floors_of_pieces.begin()->first, 0);
  EXPECT_EQ(floors_of_pieces.rbegin()->first, scene.num_pieces - 1);
  for (const auto& [piece_idx, floors] : floors_of_pieces) EXPECT_EQ(floors.size(), 1U);

  std::set<std::pair<int, Label>> distinct;
  std::map<bool, int> num_on_floor;
  for (const Box& thing : TrueThings(scene.boxes)) {
    EXPECT_TRUE(distinct.emplace(thing.piece_idx, thing.label).second);
    ++num_on_floor[thing.center.z() > storey_m];
    ExpectAround(thing, scene.boxes);
  }
  EXPECT_GT(num_on_floor[false], 3);
  EXPECT_GT(num_on_floor[true], 3);
}

TEST(TrueThings, SurfacesHaveThePieceOfTheirBox) {
  const Scene& scene = TwoFloorWorld().scene;
  std::set<std::pair<int, Label>> seen;
  for (const Surface& surface : scene.surfaces) {
    const Eigen::Vector3d middle = surface.origin + (surface.edge_u + surface.edge_v) / 2;
    const bool is_on_box = std::ranges::any_of(scene.boxes, [&](const Box& box) {
      const Eigen::Vector3d beyond = InBox(box, middle).cwiseAbs() - box.half_size;
      return box.piece_idx == surface.piece_idx && box.label == surface.label &&
             std::abs(beyond.maxCoeff()) < 1e-9;
    });
    if (surface.piece_idx < 0) {
      EXPECT_FALSE(IsThingLabel(surface.label));
    } else {
      EXPECT_TRUE(is_on_box) << LabelName(surface.label);
      seen.emplace(surface.piece_idx, surface.label);
    }
  }
  for (const Box& thing : TrueThings(scene.boxes)) {
    EXPECT_TRUE(seen.contains({thing.piece_idx, thing.label}));
  }
}

}  // namespace nightmap::true_things_test
