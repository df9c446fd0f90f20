// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/furnish.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pipeline/world/furniture.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kRoomStream = 201;
constexpr std::uint64_t kCorridorStream = 202;
constexpr double kMargin_m = 0.02;

class Furnisher {
 public:
  Furnisher(const BuildingOptions& options,
            const std::vector<Eigen::Vector2d>& route,
            double clearance_m,
            SceneBuilder& builder)
      : options_(&options), route_(&route), clearance_m_(clearance_m), builder_(&builder) {}

  bool Place(Piece& piece) {
    if (piece.Distance(*route_) < clearance_m_ + kMargin_m) return false;
    if (piece.Overlaps(builder_->Boxes())) return false;
    piece.Commit();
    return true;
  }

  // Places furniture side by side along a wall, as much as fits.
  void FillWall(const Placement& wall, double length_m, Random& random) {
    double x = 0.03;
    while (x < length_m - 0.5) {
      bool is_placed = false;
      for (int attempt = 0; attempt < 6 && !is_placed; ++attempt) {
        const auto kind = static_cast<Furniture>(random.Index(8));
        const double width_m = random.Uniform(0.75, 1.5);
        Random piece_random(random.Next());
        if (x + width_m > length_m || (kind == Furniture::kDesk && width_m < 1.1)) continue;
        Piece piece({wall.ToBuilding({x, 0.01}), wall.yaw_rad}, *builder_);
        BuildFurniture(kind, width_m, piece_random, piece);
        is_placed = Place(piece);
        if (is_placed) x += width_m + random.Uniform(0.03, 0.15);
      }
      if (!is_placed) x += 0.15;
    }
  }

  // Hangs pictures along a wall where nothing stands before it. `repeated_ratio` of them are the
  // building's notice board, and `empty_ratio` of the places stay empty.
  void HangPictures(const Placement& wall,
                    double length_m,
                    double repeated_ratio,
                    double empty_ratio,
                    Random& random) {
    double x = random.Uniform(0.1, 0.3);
    while (x < length_m - 0.3) {
      const double width_m = random.Uniform(0.4, 0.8);
      const double height_m = random.Uniform(0.45, 0.85);
      const double low_m = random.Uniform(0.7, 1.1);
      const bool is_repeated = random.Uniform() < repeated_ratio;
      const bool is_empty = random.Uniform() < empty_ratio;
      const std::uint64_t picture_seed = random.Next();
      const double used_m = is_repeated ? 0.7 : width_m;
      if (!is_empty && x + used_m < length_m &&
          HangPicture(wall, {x, low_m, used_m, height_m}, is_repeated, picture_seed)) {
        x += used_m;
      }
      x += random.Uniform(0.15, 0.4);
    }
  }

  void HangSign(const Room& room, std::uint64_t sign_seed) {
    // On the corridor side, where x runs against the room's.
    const double x = room.door_x_m + options_->door_width_m / 2 + 0.4;
    const Placement wall{room.ToBuilding({x, -options_->wall_thickness_m}),
                         room.Yaw_rad() + std::numbers::pi};
    HangPicture(wall, {0, 1.35, 0.26, 0.3}, false, sign_seed);
  }

 private:
  struct Frame {
    double x, z, width, height;
  };

  bool HangPicture(const Placement& wall,
                   const Frame& at,
                   bool is_repeated,
                   std::uint64_t picture_seed) {
    const auto building_seed = static_cast<std::uint64_t>(options_->seed);
    const double z = is_repeated ? 0.9 : at.z;
    const double height = is_repeated ? 0.7 : at.height;
    const Material frame = builder_->Plain({0.3F, 0.25F, 0.2F});
    const Material picture = is_repeated ? builder_->Picture(Paint::kPanel, building_seed)
                                         : builder_->Picture(Paint::kPoster, picture_seed);
    Piece piece(wall, *builder_);
    piece.Add({at.x, 0, z},
              {at.x + at.width, 0.015, z + height},
              SurfaceLabel::kPoster,
              frame,
              0,
              &picture);
    return Place(piece);
  }

  const BuildingOptions* options_;
  const std::vector<Eigen::Vector2d>* route_;
  double clearance_m_;
  SceneBuilder* builder_;
};

void FurnishRoom(const Room& room, Random& random, Furnisher& furnisher, SceneBuilder& builder) {
  const double width = room.Width_m();
  const double depth = room.Depth_m();
  const double yaw = room.Yaw_rad();
  constexpr double kRight = std::numbers::pi / 2;
  const Placement back{room.ToBuilding({width, depth}), yaw + 2 * kRight};
  const Placement left{room.ToBuilding({0, depth}), yaw - kRight};
  const Placement right{room.ToBuilding({width, 0}), yaw + kRight};
  const double door_end = room.door_x_m + 0.65;
  const Placement front{room.ToBuilding({door_end, 0}), yaw};
  furnisher.FillWall(back, width, random);
  furnisher.FillWall(right, depth, random);
  furnisher.FillWall(left, depth, random);
  furnisher.FillWall(front, width - door_end, random);
  const Placement middle{room.ToBuilding({width / 2 - 0.5, 0.47 * depth - 0.3}), yaw};
  Piece table(middle, builder);
  BuildFurniture(Furniture::kTable, 1.0, random, table);
  furnisher.Place(table);
  furnisher.HangPictures(back, width, 0, 0.1, random);
  furnisher.HangPictures(right, depth, 0, 0.1, random);
  furnisher.HangPictures(left, depth, 0, 0.1, random);
  furnisher.HangPictures(front, width - door_end, 0, 0, random);
}

struct CorridorWall {
  int part = 0;  // equal for two walls that a half turn about the building's centre swaps
  Placement placement;
  double length_m = 0;
};

// The walls of the loop between doorways, as placements.
std::vector<CorridorWall> CorridorWalls(const FloorLayout& layout) {
  constexpr double kDoorMargin_m = 0.15;
  constexpr double kRight = std::numbers::pi / 2;
  const Rect2& s = layout.corridor[0];
  const Rect2& n = layout.corridor[2];
  const double width = s.y1 - s.y0;
  // From one end to the other with the corridor on the left-hand side (y of the placement).
  const std::vector<CorridorWall> whole = {
      {1, {{s.x0, s.y0}, 0}, s.x1 - s.x0},
      {2, {{s.x1 - width, s.y1}, 2 * kRight}, s.x1 - s.x0 - 2 * width},
      {2, {{s.x0 + width, n.y0}, 0}, s.x1 - s.x0 - 2 * width},
      {1, {{n.x1, n.y1}, 2 * kRight}, n.x1 - n.x0},
      {3, {{s.x1, s.y0}, kRight}, n.y1 - s.y0},
      {4, {{s.x1 - width, n.y0}, -kRight}, n.y0 - s.y1},
      {3, {{s.x0, n.y1}, -kRight}, n.y1 - s.y0},
      {4, {{s.x0 + width, s.y1}, kRight}, n.y0 - s.y1}};
  std::vector<CorridorWall> parts;
  for (const CorridorWall& wall : whole) {
    std::vector<std::pair<double, double>> gaps;
    for (const Rect2& doorway : layout.doorways) {
      const double middle_y = (doorway.y0 + doorway.y1) / 2;
      const bool is_along_x = std::abs(std::sin(wall.placement.yaw_rad)) < 0.5;
      if (!is_along_x || std::abs(middle_y - wall.placement.origin.y()) > width / 2) continue;
      const double a = std::abs(doorway.x0 - wall.placement.origin.x());
      const double b = std::abs(doorway.x1 - wall.placement.origin.x());
      gaps.emplace_back(std::min(a, b) - kDoorMargin_m, std::max(a, b) + kDoorMargin_m);
    }
    const bool is_west_wall = wall.placement.origin.isApprox(Eigen::Vector2d(n.x0, n.y1));
    if (layout.ramp_hall && is_west_wall) {
      const Rect2& passage = layout.ramp_hall->passage;
      gaps.emplace_back(n.y1 - passage.y1 - kDoorMargin_m, n.y1 - passage.y0 + kDoorMargin_m);
    }
    const double wall_x = wall.placement.origin.x();
    const bool is_beside_blank = layout.blank.Area() > 0 && std::abs(wall_x - s.x1) < 1.01 * width;
    if (is_beside_blank && std::abs(std::cos(wall.placement.yaw_rad)) < 0.5) {
      const double a = std::abs(layout.blank.y0 - wall.placement.origin.y());
      const double b = std::abs(layout.blank.y1 - wall.placement.origin.y());
      gaps.emplace_back(std::min(a, b), std::max(a, b));
    }
    gaps.emplace_back(wall.length_m, wall.length_m);
    std::sort(gaps.begin(), gaps.end());
    double start = 0;
    int part = wall.part;
    for (const auto& [low, high] : gaps) {
      parts.push_back(
          {part, {wall.placement.ToBuilding({start, 0}), wall.placement.yaw_rad}, low - start});
      start = high;
      part += 10;
    }
  }
  return parts;
}

}  // namespace

void Furnish(const FloorLayout& layout,
             const BuildingOptions& options,
             const std::vector<Eigen::Vector2d>& route,
             double clearance_m,
             SceneBuilder& builder) {
  Furnisher furnisher(options, route, clearance_m, builder);
  const auto seed = static_cast<std::uint64_t>(options.seed);
  for (std::size_t i = 0; i < layout.rooms.size(); ++i) {
    const Room& room = layout.rooms[i];
    furnisher.HangSign(room, Random(seed, kCorridorStream, i + 1).Next());
    Random random(seed, kRoomStream, static_cast<std::uint64_t>(room.style));
    FurnishRoom(room, random, furnisher, builder);
  }
  Random random(seed, kCorridorStream);
  for (const CorridorWall& wall : CorridorWalls(layout)) {
    if (wall.length_m < 0.5) continue;
    if (options.mirrored_corridors) {
      random = Random(seed, kCorridorStream, static_cast<std::uint64_t>(1000 + wall.part));
    }
    if (wall.length_m > 1.5 && random.Uniform() < 0.5) {
      const double width_m = random.Uniform(0.7, 1.1);
      const double x = random.Uniform(0.1, wall.length_m - width_m);
      Piece shelf({wall.placement.ToBuilding({x, 0.005}), wall.placement.yaw_rad}, builder);
      BuildFurniture(Furniture::kLowShelf, width_m, random, shelf);
      furnisher.Place(shelf);
    }
    furnisher.HangPictures(
        wall.placement, wall.length_m, options.repeated_panel_ratio, 0.15, random);
  }
}

}  // namespace nightmap
