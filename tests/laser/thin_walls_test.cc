// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/thin_walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include "pipeline/base/random.h"

namespace nightmap::thin_walls_test {

constexpr int kSize = 60;

// A grid with the hits of its cells; free at first.
struct Drawing {
  OccupancyGrid grid;
  std::vector<std::uint32_t> hits;

  explicit Drawing(int width = kSize, int height = kSize) {
    grid.width = width;
    grid.height = height;
    grid.cells.assign(grid.Index(0, height), kFreeCell);
    hits.assign(grid.cells.size(), 0);
  }
  void Put(int x, int y, std::uint32_t count) {
    grid.cells[grid.Index(x, y)] = kOccupiedCell;
    hits[grid.Index(x, y)] = count;
  }
  void PutValue(int x, int y, CellValue value) { grid.cells[grid.Index(x, y)] = value; }
  OccupancyGrid Thinned() const {
    OccupancyGrid thinned = grid;
    ThinWalls(hits, &thinned);
    return thinned;
  }
};

// A wall through the middle of the grid, free on the side that its normal points away from. Hits
// are by the distance of a cell from the line, in cells; 0: not occupied.
struct Wall {
  Eigen::Vector2d normal;
  double offset_cells = 0;
  Drawing drawing;

  Wall(double angle_rad,
       double offset,
       const std::function<std::uint32_t(double distance_cells)>& hits_at)
      : normal(-std::sin(angle_rad), std::cos(angle_rad)), offset_cells(offset) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double distance_cells = Distance_cells({x, y});
        if (const std::uint32_t count = hits_at(distance_cells)) {
          drawing.Put(x, y, count);
        } else {
          drawing.PutValue(x, y, distance_cells < 0 ? kFreeCell : kUnknownCell);
        }
      }
    }
  }

  double Distance_cells(const Eigen::Vector2i& cell) const {
    return normal.dot((cell.array() - kSize / 2).matrix().cast<double>()) - offset_cells;
  }
  // The neighbour across the wall.
  Eigen::Vector2i Across() const {
    const Eigen::Vector2d rounded = (normal / normal.cwiseAbs().maxCoeff()).array().round();
    const bool is_oblique = normal.cwiseAbs().minCoeff() > std::sin(std::numbers::pi / 8);
    if (is_oblique) return {normal.x() > 0 ? 1 : -1, normal.y() > 0 ? 1 : -1};
    return normal.cwiseAbs().x() > normal.cwiseAbs().y()
               ? Eigen::Vector2i(static_cast<int>(rounded.x()), 0)
               : Eigen::Vector2i(0, static_cast<int>(rounded.y()));
  }
};

std::uint32_t SmearedHits(double distance_cells) {
  if (std::abs(distance_cells) >= 1.5) return 0;
  return distance_cells < -0.5 ? 30 : distance_cells < 0.5 ? 100 : 20;
}

// No end of a wall within the window that its direction is taken from.
bool IsInside(const Eigen::Vector2i& cell) {
  return cell.minCoeff() >= 10 && cell.maxCoeff() < kSize - 10;
}

std::vector<Eigen::Vector2i> OccupiedInside(const OccupancyGrid& grid) {
  std::vector<Eigen::Vector2i> cells;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      if (grid.At({x, y}) == kOccupiedCell && IsInside({x, y})) cells.emplace_back(x, y);
    }
  }
  return cells;
}

// Cells that hang together by sides and corners with the first one.
std::size_t NumConnected(const std::vector<Eigen::Vector2i>& cells) {
  std::set<std::pair<int, int>> left;
  for (const Eigen::Vector2i& cell : cells) left.emplace(cell.x(), cell.y());
  std::vector<std::pair<int, int>> open{*left.begin()};
  left.erase(left.begin());
  std::size_t count = 0;
  for (; !open.empty(); ++count) {
    const auto [x, y] = open.back();
    open.pop_back();
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (left.erase({x + dx, y + dy})) open.emplace_back(x + dx, y + dy);
      }
    }
  }
  return count;
}

// The longer side of the box around cells.
int Extent_cells(const std::vector<Eigen::Vector2i>& cells) {
  Eigen::Vector2i low = cells[0], high = cells[0];
  for (const Eigen::Vector2i& cell : cells) {
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  }
  return (high - low).maxCoeff();
}

// On each line of cells across the wall one stays: the one with most hits.
void ExpectOneCellAcross(const Wall& wall, const OccupancyGrid& thinned) {
  for (const Eigen::Vector2i& cell : OccupiedInside(wall.drawing.grid)) {
    int num_left = 0;
    std::uint32_t most = 0, left = 0;
    for (int step = -3; step <= 3; ++step) {
      const Eigen::Vector2i other = cell + step * wall.Across();
      const std::uint32_t hits = wall.drawing.hits[thinned.Index(other.x(), other.y())];
      most = std::max(most, hits);
      if (thinned.At(other) != kOccupiedCell) continue;
      ++num_left;
      left = hits;
    }
    EXPECT_EQ(num_left, 1) << cell.transpose();
    EXPECT_EQ(left, most) << cell.transpose();
  }
}

constexpr double kDegree_rad = std::numbers::pi / 180;

TEST(ThinWalls, ASmearedWallBecomesOneCellWide) {
  for (const double angle_deg : {0, 30, 45, 90, 120, 135, 180, 210, 225, 270}) {
    for (const double offset_cells : {0.0, 0.2, -0.3}) {
      SCOPED_TRACE(testing::Message() << angle_deg << " deg, " << offset_cells);
      const Wall wall(angle_deg * kDegree_rad, offset_cells, SmearedHits);
      const OccupancyGrid thinned = wall.drawing.Thinned();
      ExpectOneCellAcross(wall, thinned);
    }
  }
}

TEST(ThinWalls, WhatGoesIsFreeInFrontOfTheWallAndUnknownBehind) {
  for (const double angle_deg : {0, 30, 45, 90, 120, 135, 180, 210, 225, 270}) {
    SCOPED_TRACE(angle_deg);
    const Wall wall(angle_deg * kDegree_rad, 0, SmearedHits);
    const OccupancyGrid thinned = wall.drawing.Thinned();
    int num_free = 0, num_unknown = 0;
    for (const Eigen::Vector2i& cell : OccupiedInside(wall.drawing.grid)) {
      const int value = thinned.At(cell);
      if (value == kOccupiedCell) continue;
      EXPECT_EQ(value, wall.Distance_cells(cell) < 0 ? kFreeCell : kUnknownCell)
          << cell.transpose();
      ++(value == kFreeCell ? num_free : num_unknown);
    }
    EXPECT_GT(num_free, 10);
    EXPECT_GT(num_unknown, 10);
  }
}

TEST(ThinWalls, AllThatGoesInFrontOfAWallIsFree) {
  const auto hits_in_front = [](double distance_cells) -> std::uint32_t {
    if (distance_cells < -2.5 || distance_cells > 0.5) return 0;
    return distance_cells < -1.5 ? 5 : distance_cells < -0.5 ? 30 : 100;
  };
  for (const double angle_deg : {0, 90, 180, 270}) {
    SCOPED_TRACE(angle_deg);
    const Wall wall(angle_deg * kDegree_rad, 0, hits_in_front);
    const OccupancyGrid thinned = wall.drawing.Thinned();
    for (const Eigen::Vector2i& cell : OccupiedInside(wall.drawing.grid)) {
      const bool is_wall = std::abs(wall.Distance_cells(cell)) < 0.5;
      EXPECT_EQ(thinned.At(cell), is_wall ? kOccupiedCell : kFreeCell) << cell.transpose();
    }
  }
}

TEST(ThinWalls, TheInsideOfAPartitionIsUnknown) {
  const auto two_faces = [](double distance_cells) -> std::uint32_t {
    const double from_face = std::abs(std::abs(distance_cells) - 1);
    if (std::abs(distance_cells) > 1.5) return 0;
    return from_face < 0.5 ? 100 : 20;
  };
  for (const double angle_deg : {0, 90}) {
    SCOPED_TRACE(angle_deg);
    Wall wall(angle_deg * kDegree_rad, 0, two_faces);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        if (wall.Distance_cells({x, y}) > 1.5) wall.drawing.PutValue(x, y, kFreeCell);
      }
    }
    const OccupancyGrid thinned = wall.drawing.Thinned();
    for (const Eigen::Vector2i& cell : OccupiedInside(wall.drawing.grid)) {
      const bool is_face = std::abs(wall.Distance_cells(cell)) > 0.5;
      EXPECT_EQ(thinned.At(cell), is_face ? kOccupiedCell : kUnknownCell) << cell.transpose();
    }
  }
}

TEST(ThinWalls, NoWallGetsAHole) {
  for (int angle_deg = 0; angle_deg < 180; angle_deg += 3) {
    for (const double sigma_cells : {0.6, 0.8, 1.0}) {
      for (const double offset_cells : {0.0, 0.35, 0.5}) {
        SCOPED_TRACE(testing::Message()
                     << angle_deg << " deg, " << sigma_cells << ", " << offset_cells);
        const Wall wall(angle_deg * kDegree_rad, offset_cells, [&](double distance_cells) {
          const double share = distance_cells / sigma_cells;
          if (std::abs(distance_cells) > 1.8) return 0U;
          return static_cast<std::uint32_t>(std::lround(1000 * std::exp(-share * share / 2)));
        });
        const std::vector<Eigen::Vector2i> left = OccupiedInside(wall.drawing.Thinned());
        const std::vector<Eigen::Vector2i> before = OccupiedInside(wall.drawing.grid);
        ASSERT_FALSE(left.empty());
        EXPECT_EQ(NumConnected(left), left.size());
        EXPECT_LT(left.size(), before.size() / 2);
        for (const Eigen::Vector2i& cell : left) {
          EXPECT_LT(std::abs(wall.Distance_cells(cell)), 1.5) << cell.transpose();
        }
        EXPECT_GE(Extent_cells(left), kSize - 20 - 2);  // from end to end
      }
    }
  }
}

// Rows left of cells across a wall that is `hits` wide, from row 20 up.
std::vector<int> RowsLeft(const std::vector<std::uint32_t>& hits) {
  Drawing drawing;
  for (int x = 0; x < kSize; ++x) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i]) drawing.Put(x, 20 + static_cast<int>(i), hits[i]);
    }
  }
  const OccupancyGrid thinned = drawing.Thinned();
  std::vector<int> rows;
  for (int i = 0; i < std::ssize(hits); ++i) {
    if (thinned.At({kSize / 2, 20 + i}) == kOccupiedCell) rows.push_back(i);
  }
  return rows;
}

TEST(ThinWalls, OfEqualCellsOneStays) {
  EXPECT_EQ(RowsLeft({50, 50}).size(), 1U);
  EXPECT_EQ(RowsLeft({50, 50, 50}).size(), 1U);
  EXPECT_EQ(RowsLeft({50, 90, 90, 20}).size(), 1U);
  for (const double angle_deg : {0, 30, 45, 90, 120, 135}) {
    SCOPED_TRACE(angle_deg);
    const Wall wall(angle_deg * kDegree_rad, 0, [](double distance_cells) {
      return std::abs(distance_cells) < 1.5 ? 40U : 0U;
    });
    ExpectOneCellAcross(wall, wall.drawing.Thinned());
  }
}

// A partition is seen from both sides; nobody sees what is between its faces.
TEST(ThinWalls, APartitionKeepsBothFaces) {
  EXPECT_EQ(RowsLeft({100, 0, 90}), (std::vector<int>{0, 2}));
  EXPECT_EQ(RowsLeft({100, 0, 0, 90}), (std::vector<int>{0, 3}));
  Drawing drawing;
  for (int x = 0; x < kSize; ++x) {
    drawing.Put(x, 19, 30);
    drawing.Put(x, 20, 100);
    drawing.PutValue(x, 21, kUnknownCell);
    drawing.Put(x, 22, 100);
    drawing.Put(x, 23, 30);
  }
  const OccupancyGrid thinned = drawing.Thinned();
  EXPECT_EQ(thinned.At({30, 20}), kOccupiedCell);
  EXPECT_EQ(thinned.At({30, 21}), kUnknownCell);
  EXPECT_EQ(thinned.At({30, 22}), kOccupiedCell);
}

void ExpectUnchanged(const Drawing& drawing) {
  EXPECT_EQ(drawing.Thinned().cells, drawing.grid.cells);
}

TEST(ThinWalls, WhatIsOneCellWideStaysWhateverItsHits) {
  Random random(1);
  const auto hits = [&] { return static_cast<std::uint32_t>(20 + random.Index(81)); };
  for (int repetition = 0; repetition < 20; ++repetition) {
    SCOPED_TRACE(repetition);
    Drawing straight, room, junction, post;
    for (int i = 10; i < 50; ++i) {
      straight.Put(i, 30, hits());
      for (const auto& [x, y] : {std::pair(i, 10), {i, 49}, {10, i}, {49, i}}) {
        room.Put(x, y, hits());
      }
      junction.Put(i, 30, hits());
      if (i > 30) junction.Put(30, i, hits());
    }
    post.Put(30, 30, hits());
    post.Put(40, 30, hits());
    post.Put(41, 30, hits());
    ExpectUnchanged(straight);
    ExpectUnchanged(room);
    ExpectUnchanged(junction);
    ExpectUnchanged(post);
  }
}

TEST(ThinWalls, PostsAndClutterStay) {
  Random random(2);
  Drawing posts, clutter;
  for (int y = 28; y < 31; ++y) {
    for (int x = 28; x < 31; ++x) posts.Put(x, y, 10 + static_cast<std::uint32_t>(random.Index(9)));
  }
  ExpectUnchanged(posts);
  for (int y = 15; y < 45; ++y) {
    for (int x = 15; x < 45; ++x) {
      if (random.Uniform() < 0.7) clutter.Put(x, y, 20 + static_cast<std::uint32_t>(x % 7));
    }
  }
  const OccupancyGrid thinned = clutter.Thinned();
  for (int y = 20; y < 40; ++y) {  // its rim is as straight as a wall
    for (int x = 20; x < 40; ++x) EXPECT_EQ(thinned.At({x, y}), clutter.grid.At({x, y}));
  }
}

TEST(ThinWalls, ACornerOfARoomKeepsItsCellsAndItsWallsBecomeThin) {
  Drawing drawing;
  for (int i = 7; i < 45; ++i) {
    for (const auto& [aside, hits] : {std::pair(0, 20U), {2, 30U}, {1, 100U}}) {
      if (i < 7 + aside) continue;
      drawing.Put(i, 7 + aside, std::max(hits, drawing.hits[drawing.grid.Index(i, 7 + aside)]));
      drawing.Put(7 + aside, i, std::max(hits, drawing.hits[drawing.grid.Index(7 + aside, i)]));
    }
  }
  const OccupancyGrid thinned = drawing.Thinned();
  EXPECT_EQ(thinned.At({8, 8}), kOccupiedCell);
  for (int i = 8; i < 40; ++i) {
    EXPECT_EQ(thinned.At({i, 8}), kOccupiedCell) << i;
    EXPECT_EQ(thinned.At({8, i}), kOccupiedCell) << i;
    if (i < 20) continue;
    EXPECT_EQ(thinned.At({i, 7}), kFreeCell) << i;
    EXPECT_EQ(thinned.At({9, i}), kFreeCell) << i;
  }
}

TEST(ThinWalls, WallsAtTheBorderOfTheGrid) {
  for (const bool is_upright : {false, true}) {
    for (const bool is_far : {false, true}) {
      for (const int first : {0, 1}) {  // row of most hits
        SCOPED_TRACE(testing::Message() << is_upright << is_far << first);
        Drawing drawing(30, 30);
        const auto cell = [&](int along, int row) {
          const int y = is_far ? 29 - row : row;
          return is_upright ? Eigen::Vector2i(y, along) : Eigen::Vector2i(along, y);
        };
        for (int along = 0; along < 30; ++along) {
          for (int row = 0; row <= first + 1; ++row) {
            const Eigen::Vector2i at = cell(along, row);
            drawing.Put(at.x(), at.y(), row == first ? 100 : 30);
          }
        }
        const OccupancyGrid thinned = drawing.Thinned();
        for (int along = 0; along < 30; ++along) {
          EXPECT_EQ(thinned.At(cell(along, first)), kOccupiedCell) << along;
          if (along < 4 || along > 25) continue;  // a wall's end has less of a direction
          EXPECT_EQ(thinned.At(cell(along, first + 1)), kFreeCell) << along;
          if (first == 1) {
            EXPECT_EQ(thinned.At(cell(along, 0)), kUnknownCell) << along;
          }
        }
      }
    }
  }
}

TEST(ThinWalls, SmallGrids) {
  OccupancyGrid empty;
  ThinWalls({}, &empty);
  EXPECT_TRUE(empty.cells.empty());
  for (const auto& [width, height] : {std::pair(1, 1), {1, 5}, {5, 1}, {2, 2}}) {
    Drawing drawing(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) drawing.Put(x, y, 3);
    }
    ExpectUnchanged(drawing);
  }
}

}  // namespace nightmap::thin_walls_test
