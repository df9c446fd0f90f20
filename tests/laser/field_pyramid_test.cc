// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/field_pyramid.h"

#include <algorithm>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::field_pyramid_test {

constexpr int kNumLevels = 6;

// Some have points in a part only, at the border, or none.
LikelihoodField RandomField(Random& random) {
  LikelihoodField field({.resolution_m = 0.1, .half_extent_m = random.Uniform(0.3, 2.5)});
  const Eigen::Vector2d center(random.Uniform(-2, 2), random.Uniform(-2, 2));
  const double spread_m = random.Uniform(0, 2);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 12; ++i) {
    points.push_back(center + spread_m * Eigen::Vector2d(random.Gaussian(), random.Gaussian()));
  }
  field.Add(points);
  return field;
}

// The largest of the cells of the field, one by one.
int LargestOf(const LikelihoodField& field, int column, int row, int side) {
  int largest = 0;
  for (int y = row; y < row + side; ++y) {
    for (int x = column; x < column + side; ++x) {
      largest = std::max(largest, static_cast<int>(255 * field.At(x, y) + 0.5F));
    }
  }
  return largest;
}

// Squares within the field, over its border, and outside.
TEST(FieldPyramid, ASquareHasTheLargestValueOfItsCells) {
  Random random(7);
  for (int round = 0; round < 40; ++round) {
    const LikelihoodField field = RandomField(random);
    const FieldPyramid pyramid(field, kNumLevels);
    ASSERT_EQ(pyramid.NumLevels(), kNumLevels);
    for (int level = 0; level < kNumLevels; ++level) {
      const int side = 1 << level;
      for (int row = -side - 2; row < field.Size() + 2; ++row) {
        for (int column = -side - 2; column < field.Size() + 2; ++column) {
          ASSERT_EQ(pyramid.At(level, column, row), LargestOf(field, column, row, side))
              << "round " << round << " level " << level << " at " << column << " " << row;
        }
      }
    }
  }
}

TEST(FieldPyramid, IsZeroFarOutside) {
  Random random(8);
  const LikelihoodField field = RandomField(random);
  const FieldPyramid pyramid(field, kNumLevels);
  for (int level = 0; level < kNumLevels; ++level) {
    for (const int away : {-1'000'000, 1'000'000}) {
      EXPECT_EQ(pyramid.At(level, away, 0), 0);
      EXPECT_EQ(pyramid.At(level, 0, away), 0);
      EXPECT_EQ(pyramid.At(level, away, away), 0);
    }
  }
}

TEST(FieldPyramid, IsZeroWithoutPoints) {
  const LikelihoodField field({.resolution_m = 0.1, .half_extent_m = 1});
  const FieldPyramid pyramid(field, kNumLevels);
  for (int level = 0; level < kNumLevels; ++level) {
    for (int column = -70; column < 30; ++column) EXPECT_EQ(pyramid.At(level, column, 5), 0);
  }
}

TEST(FieldPyramid, APointIsOneAndSoIsEachSquareWithIt) {
  LikelihoodField field({.resolution_m = 0.1, .half_extent_m = 1});
  field.Add({{0.05, -0.25}});  // the centre of cell (10, 7)
  const FieldPyramid pyramid(field, kNumLevels);
  EXPECT_EQ(&pyramid.Field(), &field);
  for (int level = 0; level < kNumLevels; ++level) {
    const int side = 1 << level;
    EXPECT_EQ(pyramid.At(level, 10, 7), 255);
    EXPECT_EQ(pyramid.At(level, 11 - side, 8 - side), 255);
    EXPECT_LT(pyramid.At(level, 11, 7), 255);
    EXPECT_LT(pyramid.At(level, 10 - side, 7), 255);
  }
}

TEST(FieldPyramid, DoesNotChangeWithTheField) {
  LikelihoodField field({.resolution_m = 0.1, .half_extent_m = 1});
  const FieldPyramid pyramid(field, 2);
  field.Add({{0.05, 0.05}});
  EXPECT_EQ(pyramid.At(0, 10, 10), 0);
  EXPECT_EQ(pyramid.At(1, 10, 10), 0);
  EXPECT_EQ(FieldPyramid(field, 2).At(1, 10, 10), 255);
}

}  // namespace nightmap::field_pyramid_test
