// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/shell.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "pipeline/base/random.h"
#include "pipeline/world/fit_ceiling.h"
#include "pipeline/world/furniture.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kWallStream = 101;
constexpr std::uint64_t kFloorStream = 102;

// Offset that makes a tiled texture continue from one surface to the next in the same plane.
void AnchorTexture(const Eigen::Vector3d& anchor, Surface& surface) {
  const Eigen::Vector3d from_anchor = surface.origin - anchor;
  surface.material.offset_m += Eigen::Vector2d(from_anchor.dot(surface.edge_u.normalized()),
                                               from_anchor.dot(surface.edge_v.normalized()));
}

// Material of a wall's face, by the room that it faces.
class WallMaterials {
 public:
  WallMaterials(const FloorLayout& layout, const BuildingOptions& options, SceneBuilder& builder)
      : layout_(&layout), seed_(static_cast<std::uint64_t>(options.seed)), builder_(&builder) {}

  void Apply(Surface& face) {
    const Eigen::Vector3d normal = face.Normal();
    const Eigen::Vector3d front = face.origin + (face.edge_u + face.edge_v) / 2 + 0.03 * normal;
    for (const Room& room : layout_->rooms) {
      if (!room.area.Contains(front.x(), front.y())) continue;
      const int side = SideOf(normal.head<2>() * room.inward.y());
      face.material = MaterialOf(room.style + 1, side);
      const Eigen::Vector2d anchor = room.ToBuilding({0, 0});
      return AnchorTexture({anchor.x(), anchor.y(), 0}, face);
    }
    if (layout_->blank.Contains(front.x(), front.y())) {
      face.material = builder_->Uniform({0.75F, 0.74F, 0.7F});
      return;
    }
    face.material = MaterialOf(0, SideOf(normal.head<2>()));
    AnchorTexture(Eigen::Vector3d::Zero(), face);
  }

 private:
  static int SideOf(const Eigen::Vector2d& normal) {
    if (std::abs(normal.x()) > std::abs(normal.y())) return normal.x() > 0 ? 0 : 1;
    return normal.y() > 0 ? 2 : 3;
  }

  const Material& MaterialOf(int place, int side) {
    const auto [found, is_new] = materials_.try_emplace({place, side});
    if (is_new) {
      Random random(seed_, kWallStream, static_cast<std::uint64_t>(place * 4 + side));
      // Half of the walls are nearly blank, as in most buildings.
      constexpr std::array<Paint, 6> kPaints = {Paint::kPlaster,
                                                Paint::kPlaster,
                                                Paint::kPlaster,
                                                Paint::kWallpaper,
                                                Paint::kBrick,
                                                Paint::kWallpaper};
      found->second = builder_->Tiled(kPaints[random.Index(kPaints.size())], random);
    }
    return found->second;
  }

  const FloorLayout* layout_;
  std::uint64_t seed_;
  SceneBuilder* builder_;
  std::map<std::pair<int, int>, Material> materials_;
};

void AddWallBox(
    const Rect2& rect, double z0, double z1, WallMaterials& materials, SceneBuilder& builder) {
  Box box;
  box.center = {(rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2, (z0 + z1) / 2};
  box.half_size = {(rect.x1 - rect.x0) / 2, (rect.y1 - rect.y0) / 2, (z1 - z0) / 2};
  box.label = SurfaceLabel::kWall;
  builder.AddSolid(box);
  for (Surface face : BoxFaces(box, Material{})) {
    const double normal_z = face.Normal().z();
    if (std::abs(normal_z) > 0.5 && (z0 <= 0 || normal_z > 0)) continue;  // in floor or ceiling
    materials.Apply(face);
    builder.AddSurface(face);
  }
}

// Adds a wall along x, cut at its doorways and at every room's sides, so that each piece borders at
// most one room.
void AddWallAlongX(const Rect2& rect,
                   const FloorLayout& layout,
                   double height_m,
                   WallMaterials& materials,
                   SceneBuilder& builder) {
  std::vector<double> cuts = {rect.x0, rect.x1};
  const auto is_inside = [&](double x) { return x > rect.x0 + 1e-6 && x < rect.x1 - 1e-6; };
  for (const Room& room : layout.rooms) {
    for (const double x : {room.area.x0, room.area.x1}) {
      if (is_inside(x)) cuts.push_back(x);
    }
  }
  std::vector<Rect2> gaps;
  for (const Rect2& doorway : layout.doorways) {
    const double middle_y = (doorway.y0 + doorway.y1) / 2;
    if (!rect.Contains((doorway.x0 + doorway.x1) / 2, middle_y)) continue;
    gaps.push_back(doorway);
    cuts.insert(cuts.end(), {doorway.x0, doorway.x1});
  }
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (cuts[i + 1] - cuts[i] < 1e-6) continue;
    const double middle = (cuts[i] + cuts[i + 1]) / 2;
    const bool is_gap = std::any_of(gaps.begin(), gaps.end(), [middle](const Rect2& gap) {
      return middle > gap.x0 && middle < gap.x1;
    });
    const Rect2 part{cuts[i], rect.y0, cuts[i + 1], rect.y1};
    AddWallBox(part, is_gap ? kDoorHeight_m : 0, height_m, materials, builder);
  }
}

// Cuts a rectangle where the blank stretch beside or in it begins and ends.
std::vector<Rect2> CutAtBlank(const Rect2& rect, const Rect2& blank) {
  constexpr double kBeside_m = 1e-6;
  const bool is_beside = rect.x0 < blank.x1 + kBeside_m && rect.x1 > blank.x0 - kBeside_m;
  if (blank.Area() <= 0 || !is_beside) return {rect};
  std::vector<Rect2> parts;
  double y0 = rect.y0;
  for (const double end : {blank.y0, blank.y1, rect.y1}) {
    const double y1 = std::clamp(end, rect.y0, rect.y1);
    if (y1 > y0) parts.push_back({rect.x0, y0, rect.x1, y1});
    y0 = y1;
  }
  return parts;
}

void AddWallAlongY(const Rect2& rect,
                   const FloorLayout& layout,
                   double height_m,
                   WallMaterials& materials,
                   SceneBuilder& builder) {
  for (const Rect2& part : CutAtBlank(rect, layout.blank)) {
    AddWallBox(part, 0, height_m, materials, builder);
  }
}

// Adds the corridor's outer wall, with the passage to the ramp if there is one.
void AddWestWall(const Rect2& rect,
                 const FloorLayout& layout,
                 double height_m,
                 WallMaterials& materials,
                 SceneBuilder& builder) {
  if (!layout.ramp_hall) return AddWallBox(rect, 0, height_m, materials, builder);
  const Rect2& passage = layout.ramp_hall->passage;
  AddWallBox({rect.x0, rect.y0, rect.x1, passage.y0}, 0, height_m, materials, builder);
  AddWallBox({rect.x0, passage.y1, rect.x1, rect.y1}, 0, height_m, materials, builder);
  AddWallBox(passage, kDoorHeight_m, height_m, materials, builder);
}

void AddWalls(const FloorLayout& layout, const BuildingOptions& options, SceneBuilder& builder) {
  WallMaterials materials(layout, options, builder);
  const double t = options.wall_thickness_m;
  const double height = options.ceiling_height_m;
  const Rect2& south = layout.corridor[0];
  const Rect2& north = layout.corridor[2];
  const double x0 = south.x0 + options.corridor_width_m;
  const double x1 = south.x1 - options.corridor_width_m;
  const std::vector<Rect2> along_x = {{x0, layout.extent.y0, x1, layout.extent.y0 + t},
                                      {layout.extent.x0, south.y0 - t, layout.extent.x1, south.y0},
                                      {x0, south.y1, x1, south.y1 + t},
                                      {x0, north.y0 - t, x1, north.y0},
                                      {layout.extent.x0, north.y1, layout.extent.x1, north.y1 + t},
                                      {x0, layout.extent.y1 - t, x1, layout.extent.y1}};
  for (const Rect2& wall : along_x) AddWallAlongX(wall, layout, height, materials, builder);
  AddWestWall({layout.extent.x0, south.y0, south.x0, north.y1}, layout, height, materials, builder);
  const Rect2 east{south.x1, south.y0, layout.extent.x1, north.y1};
  AddWallAlongY(east, layout, height, materials, builder);
  for (int column = 0; column <= layout.num_columns; ++column) {
    const double x = x0 + column * (options.room_width_m + t);
    for (const double y : {layout.extent.y0 + t, south.y1 + t, north.y1 + t}) {
      const Rect2 wall{x, y, x + t, y + options.room_depth_m};
      AddWallAlongY(wall, layout, height, materials, builder);
    }
  }
}

void AddSlab(
    const Rect2& rect, double z, bool is_floor, const Material& material, SceneBuilder& builder) {
  Surface slab;
  slab.origin = {rect.x0, is_floor ? rect.y1 : rect.y0, z};
  slab.edge_u = {rect.x1 - rect.x0, 0, 0};
  slab.edge_v = {0, is_floor ? rect.y0 - rect.y1 : rect.y1 - rect.y0, 0};
  slab.label = is_floor ? SurfaceLabel::kFloor : SurfaceLabel::kCeiling;
  slab.material = material;
  AnchorTexture(Eigen::Vector3d::Zero(), slab);
  builder.AddSurface(slab);
}

void AddLamps(const Rect2& rect, double ceiling_m, SceneBuilder& builder) {
  constexpr double kLampSpacing_m = 2.6;
  const double width = rect.x1 - rect.x0;
  const double depth = rect.y1 - rect.y0;
  const int num_x = std::max(1, static_cast<int>(std::lround(width / kLampSpacing_m)));
  const int num_y = std::max(1, static_cast<int>(std::lround(depth / kLampSpacing_m)));
  // Scales light by floor area, so that small rooms are no brighter than large ones.
  const double area_m2 = width * depth / (num_x * num_y);
  const auto intensity = static_cast<float>(std::clamp(0.9 + 0.37 * area_m2, 1.5, 5.0));
  for (int i = 0; i < num_x * num_y; ++i) {
    const double x = rect.x0 + width * (i % num_x + 0.5) / num_x;
    const int row = i / num_x;
    const double y = rect.y0 + depth * (row + 0.5) / num_y;
    builder.AddLamp({{x, y, ceiling_m}, {0.3, 0.3}, intensity});
  }
}

void AddFloorsAndCeilings(const FloorLayout& layout,
                          const BuildingOptions& options,
                          SceneBuilder& builder) {
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const double height = options.ceiling_height_m;
  Random corridor_random(seed, kFloorStream);
  const Material corridor_floor = builder.Tiled(Paint::kTerrazzo, corridor_random);
  const Material ceiling = builder.Tiled(Paint::kCeiling, corridor_random);
  const Rect2& south = layout.corridor[0];
  const Rect2& north = layout.corridor[2];
  const double width = options.corridor_width_m;
  const std::vector<Rect2> corridor = {south,
                                       {south.x1 - width, south.y1, south.x1, north.y0},
                                       north,
                                       {south.x0, south.y1, south.x0 + width, north.y0}};
  for (const Rect2& rect : corridor) {
    for (const Rect2& part : CutAtBlank(rect, layout.blank)) {
      const bool is_blank = layout.blank.Contains((part.x0 + part.x1) / 2, (part.y0 + part.y1) / 2);
      AddSlab(part,
              0,
              true,
              is_blank ? builder.Uniform({0.55F, 0.55F, 0.54F}) : corridor_floor,
              builder);
    }
    AddSlab(rect, height, false, ceiling, builder);
    AddLamps(rect, height, builder);
  }
  for (const Rect2& doorway : layout.doorways) AddSlab(doorway, 0, true, corridor_floor, builder);
  constexpr std::array<Paint, 3> kFloors = {Paint::kPlanks, Paint::kCarpet, Paint::kTerrazzo};
  for (std::size_t i = 0; i < layout.rooms.size(); ++i) {
    Random random(seed, kFloorStream, i + 1);  // by room, not by style: no two floors look alike
    const Material floor = builder.Tiled(kFloors[random.Index(kFloors.size())], random);
    AddSlab(layout.rooms[i].area, 0, true, floor, builder);
    AddSlab(layout.rooms[i].area, height, false, ceiling, builder);
    AddLamps(layout.rooms[i].area, height, builder);
  }
}

}  // namespace

void BuildShell(const FloorLayout& layout, const BuildingOptions& options, SceneBuilder& builder) {
  AddWalls(layout, options, builder);
  AddFloorsAndCeilings(layout, options, builder);
  FitCeilings(layout, options, builder);
  for (const Room& room : layout.rooms) BuildDoor(room, options, builder);
}

}  // namespace nightmap
