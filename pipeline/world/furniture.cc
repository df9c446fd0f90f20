// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/furniture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

using Eigen::Vector3d;
using Label = SurfaceLabel;

void AddLegs(const Vector3d& low,
             const Vector3d& high,
             Label label,
             const Material& material,
             Piece& piece) {
  constexpr double kLeg_m = 0.05;
  for (const double x : {low.x(), high.x() - kLeg_m}) {
    for (const double y : {low.y(), high.y() - kLeg_m}) {
      piece.Add({x, y, low.z()}, {x + kLeg_m, y + kLeg_m, high.z()}, label, material);
    }
  }
}

// Boxes with printed fronts on a surface, from x0 to x1, up to `max_height_m` high.
void AddObjects(double x0,
                double x1,
                double depth_m,
                double z,
                double max_height_m,
                Random& random,
                Piece& piece) {
  double x = x0 + random.Uniform(0.02, 0.1);
  while (true) {
    const double width = random.Uniform(0.1, 0.26);
    if (x + width > x1) return;
    const double thickness = random.Uniform(0.08, std::min(0.2, depth_m * 0.6));
    const double height = random.Uniform(0.4, 1.0) * max_height_m;
    const double y = random.Uniform(0.04, depth_m - thickness - 0.04);
    const Material side = piece.Builder().Tiled(Paint::kFabric, random);
    const Material print = piece.Builder().Picture(Paint::kPoster, random.Next());
    const double yaw_rad = random.Uniform(-0.25, 0.25);
    piece.Add(
        {x, y, z}, {x + width, y + thickness, z + height}, Label::kObject, side, yaw_rad, &print);
    x += width + random.Uniform(0.04, 0.25);
  }
}

void AddBooks(
    double x0, double x1, double depth_m, double z, double height_m, Random& random, Piece& piece) {
  double x = x0 + 0.01;
  while (x + 0.15 < x1) {
    const double width = std::min(x1 - x - 0.01, random.Uniform(0.18, 0.5));
    const double front = random.Uniform(0.65, 0.92) * depth_m;
    const Material spines = piece.Builder().Picture(Paint::kBooks, random.Next());
    const Material paper = piece.Builder().Plain({0.9F, 0.88F, 0.8F});
    const double top = z + height_m * random.Uniform(0.7, 0.92);
    piece.Add({x, 0.03, z}, {x + width, front, top}, Label::kObject, paper, 0, &spines);
    x += width + random.Uniform(0.01, 0.2);
  }
}

void BuildChair(const Vector3d& corner, double yaw_rad, Random& random, Piece& piece) {
  const Material fabric = piece.Builder().Tiled(Paint::kFabric, random);
  const Material wood = piece.Builder().Tiled(Paint::kWood, random);
  const Vector3d seat = corner + Vector3d(0, 0, 0.42);
  piece.Add(seat, seat + Vector3d(0.42, 0.42, 0.05), Label::kChair, fabric, yaw_rad);
  AddLegs(
      corner + Vector3d(0.04, 0.04, 0), seat + Vector3d(0.38, 0.38, 0), Label::kChair, wood, piece);
  const Vector3d back = corner + Vector3d(0.02, 0.37, 0.5);
  piece.Add(back, back + Vector3d(0.38, 0.04, 0.4), Label::kChair, fabric, yaw_rad, &fabric);
}

void BuildDesk(double width_m, Random& random, Piece& piece) {
  const Material wood = piece.Builder().Tiled(Paint::kWood, random);
  const double depth = 0.55;
  piece.Add({0, 0, 0.71}, {width_m, depth, 0.75}, Label::kTable, wood);
  AddLegs({0.02, 0.02, 0}, {width_m - 0.02, depth - 0.02, 0.71}, Label::kTable, wood, piece);
  const Material drawers = piece.Builder().Picture(Paint::kPanel, random.Next());
  piece.Add({0.1, 0.05, 0.12}, {0.5, depth - 0.05, 0.7}, Label::kCabinet, wood, 0, &drawers);
  const Material shell = piece.Builder().Plain({0.2F, 0.2F, 0.22F});
  const Material screen = piece.Builder().Picture(Paint::kPoster, random.Next());
  const double x = random.Uniform(0.15, width_m - 0.75);
  piece.Add({x, 0.12, 0.82},
            {x + 0.52, 0.16, 1.14},
            Label::kObject,
            shell,
            random.Uniform(-0.2, 0.2),
            &screen);
  piece.Add({x + 0.2, 0.1, 0.75}, {x + 0.32, 0.2, 0.82}, Label::kObject, shell);
  AddObjects(x + 0.55, width_m, depth, 0.75, 0.28, random, piece);
  BuildChair({0.55, 0.3, 0}, random.Uniform(-0.3, 0.3), random, piece);
}

void BuildTable(double width_m, Random& random, Piece& piece) {
  const Material wood = piece.Builder().Tiled(Paint::kWood, random);
  piece.Add({0, 0, 0.7}, {width_m, 0.6, 0.74}, Label::kTable, wood);
  AddLegs({0.03, 0.03, 0}, {width_m - 0.03, 0.57, 0.7}, Label::kTable, wood, piece);
  AddObjects(0, width_m, 0.6, 0.74, 0.32, random, piece);
  BuildChair({width_m / 2 - 0.2, 0.28, 0}, random.Uniform(-0.3, 0.3), random, piece);
}

// Open shelf with `num_boards` boards one above the other, filled with books and boxes.
void BuildShelf(double width_m, double height_m, int num_boards, Random& random, Piece& piece) {
  const Material wood = piece.Builder().Tiled(Paint::kWood, random);
  const double depth = 0.3;
  const double board = 0.025;
  piece.Add({0, 0, 0}, {board, depth, height_m}, Label::kShelf, wood);
  piece.Add({width_m - board, 0, 0}, {width_m, depth, height_m}, Label::kShelf, wood);
  piece.Add({board, 0, 0}, {width_m - board, 0.015, height_m}, Label::kShelf, wood);
  const double pitch = (height_m - 0.08 - board) / (num_boards - 1);
  for (int i = 0; i < num_boards; ++i) {
    const double z = 0.08 + i * pitch;
    piece.Add({board, 0.015, z}, {width_m - board, depth, z + board}, Label::kShelf, wood);
    const double clear = i + 1 < num_boards ? pitch - board : 0.3;
    if (random.Uniform() < 0.7 && i + 1 < num_boards) {
      AddBooks(board, width_m - board, depth, z + board, clear, random, piece);
    } else {
      AddObjects(board, width_m - board, depth, z + board, 0.8 * clear, random, piece);
    }
  }
}

void BuildCabinet(double width_m, double height_m, double depth_m, Random& random, Piece& piece) {
  const Material wood = piece.Builder().Tiled(Paint::kWood, random);
  const int num_doors = std::max(1, static_cast<int>(std::lround(width_m / 0.5)));
  piece.Add({0, 0, 0}, {width_m, depth_m - 0.02, height_m}, Label::kCabinet, wood);
  for (int i = 0; i < num_doors; ++i) {
    const double x0 = width_m * i / num_doors + 0.01;
    const double x1 = width_m * (i + 1) / num_doors - 0.01;
    const Material door = piece.Builder().Tiled(Paint::kWood, random);
    const Vector3d high(x1, depth_m, height_m - 0.03);
    piece.Add({x0, depth_m - 0.02, 0.06}, high, Label::kCabinet, door, 0, &door);
    const Material metal = piece.Builder().Plain({0.35F, 0.35F, 0.36F});
    piece.Add({x1 - 0.08, depth_m, height_m * 0.55},
              {x1 - 0.06, depth_m + 0.02, height_m * 0.55 + 0.14},
              Label::kCabinet,
              metal);
  }
  if (height_m < 1.8) AddObjects(0, width_m, depth_m, height_m, 0.4, random, piece);
}

void BuildBed(double width_m, Random& random, Piece& piece) {
  const Material wood = piece.Builder().Tiled(Paint::kWood, random);
  const Material cover = piece.Builder().Tiled(Paint::kFabric, random);
  const Material pillow = piece.Builder().Tiled(Paint::kFabric, random);
  const double depth = 0.75;
  piece.Add({0, 0, 0}, {width_m, depth, 0.28}, Label::kBed, wood);
  piece.Add({0.05, 0.02, 0.28}, {width_m - 0.02, depth - 0.02, 0.48}, Label::kBed, cover);
  piece.Add({0.1, 0.12, 0.48}, {0.45, depth - 0.12, 0.58}, Label::kBed, pillow, 0.1);
  piece.Add({0, 0, 0.28}, {0.05, depth, 0.85}, Label::kBed, wood);
}

void BuildSofa(double width_m, Random& random, Piece& piece) {
  const Material fabric = piece.Builder().Tiled(Paint::kFabric, random);
  const Material cushion = piece.Builder().Tiled(Paint::kFabric, random);
  const double depth = 0.75;
  piece.Add({0, 0, 0.06}, {width_m, depth, 0.42}, Label::kSofa, fabric);
  piece.Add({0, 0, 0.42}, {width_m, 0.2, 0.82}, Label::kSofa, fabric);
  piece.Add({0, 0.2, 0.42}, {0.15, depth, 0.6}, Label::kSofa, fabric);
  piece.Add({width_m - 0.15, 0.2, 0.42}, {width_m, depth, 0.6}, Label::kSofa, fabric);
  const double x = random.Uniform(0.2, width_m - 0.7);
  piece.Add({x, 0.22, 0.43}, {x + 0.4, 0.34, 0.75}, Label::kObject, cushion, 0.2, &cushion);
}

}  // namespace

double FurnitureDepth_m(Furniture kind) {
  switch (kind) {
    case Furniture::kDesk:
      return 0.75;
    case Furniture::kTable:
      return 0.72;
    case Furniture::kBed:
      return 0.75;
    case Furniture::kSofa:
      return 0.75;
    case Furniture::kWardrobe:
      return 0.5;
    case Furniture::kCabinet:
      return 0.42;
    case Furniture::kBookshelf:
      return 0.3;
    case Furniture::kLowShelf:
      return 0.3;
  }
  throw UsageError("unknown furniture {}", static_cast<int>(kind));
}

void BuildFurniture(Furniture kind, double width_m, Random& random, Piece& piece) {
  switch (kind) {
    case Furniture::kDesk:
      return BuildDesk(width_m, random, piece);
    case Furniture::kTable:
      return BuildTable(width_m, random, piece);
    case Furniture::kBed:
      return BuildBed(width_m, random, piece);
    case Furniture::kSofa:
      return BuildSofa(width_m, random, piece);
    case Furniture::kWardrobe:
      return BuildCabinet(width_m, 1.95, 0.48, random, piece);
    case Furniture::kCabinet:
      return BuildCabinet(width_m, random.Uniform(0.75, 1.2), 0.4, random, piece);
    case Furniture::kBookshelf:
      return BuildShelf(width_m, random.Uniform(1.7, 2.0), 6, random, piece);
    case Furniture::kLowShelf:
      return BuildShelf(width_m, random.Uniform(0.8, 1.2), 3, random, piece);
  }
}

}  // namespace nightmap
