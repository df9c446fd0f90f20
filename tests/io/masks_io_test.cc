// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/masks_io.h"

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::masks_io_test {

// Squares of 3 pixels, masked with this probability.
GrayImage RandomMask(int width, int height, double ratio, std::uint64_t seed) {
  GrayImage mask{width, height, 1, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Random random(seed, static_cast<std::uint64_t>(x / 3), static_cast<std::uint64_t>(y / 3));
      mask.pixels.push_back(random.Uniform() < ratio ? 255 : 0);
    }
  }
  return mask;
}

std::vector<PackedMask> SomeMasks() {
  return {PackMask(100, RandomMask(20, 10, 0.5, 1)),
          PackMask(250, RandomMask(20, 10, 0, 1)),
          PackMask(300, RandomMask(7, 30, 1, 1))};
}

TEST(PackMask, UnpacksToTheSamePixelsAndCountsThem) {
  for (const double ratio : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const GrayImage mask = RandomMask(31, 17, ratio, 3);
    const PackedMask packed = PackMask(5, mask);
    const GrayImage again = UnpackMask(packed);
    EXPECT_EQ(again.width, 31);
    EXPECT_EQ(again.height, 17);
    EXPECT_EQ(again.pixels, mask.pixels) << ratio;
    EXPECT_EQ(NumMasked(packed),
              static_cast<std::size_t>(std::ranges::count(mask.pixels, std::uint8_t{255})));
  }
}

TEST(PackMask, TheHashTellsMasksApartButNotTimes) {
  const GrayImage mask = RandomMask(12, 6, 0.5, 1);
  GrayImage other = mask;
  other.pixels[40] = static_cast<std::uint8_t>(255 - other.pixels[40]);
  GrayImage turned = mask;
  std::swap(turned.width, turned.height);
  EXPECT_EQ(HashOf(PackMask(1, mask)), HashOf(PackMask(2, mask)));
  EXPECT_NE(HashOf(PackMask(1, mask)), HashOf(PackMask(1, other)));
  EXPECT_NE(HashOf(PackMask(1, mask)), HashOf(PackMask(1, turned)));
}

TEST(MasksIo, ReadsBackEveryMask) {
  const TemporaryFolder folder;
  const auto masks = SomeMasks();
  WriteMasks(folder / "m.h5", masks, "x = 1\n");
  const auto read = ReadMasks(folder / "m.h5");
  ASSERT_EQ(read.size(), masks.size());
  for (std::size_t i = 0; i < masks.size(); ++i) {
    EXPECT_EQ(read[i].time_ns, masks[i].time_ns);
    EXPECT_EQ(read[i].width, masks[i].width);
    EXPECT_EQ(read[i].height, masks[i].height);
    EXPECT_EQ(read[i].runs, masks[i].runs);
  }
  WriteMasks(folder / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "m.h5"));
  WriteMasks(folder / "none.h5", {}, "");
  EXPECT_TRUE(ReadMasks(folder / "none.h5").empty());
}

TEST(MasksIo, WhatCannotBeIsRefused) {
  const TemporaryFolder folder;
  const auto refuse = [&](auto damage, const std::string& text) {
    std::vector<PackedMask> masks = SomeMasks();
    damage(masks);
    WriteMasks(folder / "m.h5", masks, "");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadMasks(folder / "m.h5"), "m.h5: field '" + text);
  };
  using Masks = std::vector<PackedMask>;
  refuse([](Masks& masks) { masks[1].time_ns = 100; }, "time_ns' does not ascend");
  refuse([](Masks& masks) { masks[0].width = 0; }, "size_px'");
  refuse([](Masks& masks) { masks[0].height = -10; }, "size_px'");
  refuse([](Masks& masks) { masks[0].runs.back() += 1; }, "run' does not fill its picture");
  refuse([](Masks& masks) { masks[2].runs.clear(); }, "run' does not fill its picture");
  refuse([](Masks& masks) { masks[1].runs = {100, 0, 100}; }, "run' does not fill its picture");
  refuse([](Masks& masks) { masks[1].width = 2'000'000'000; }, "run' does not fill its picture");
}

TEST(MasksIo, OffsetsThatDoNotAddUpAreRefused) {
  const TemporaryFolder folder;
  for (const std::vector<std::int64_t>& offset : std::vector<std::vector<std::int64_t>>{
           {}, {0}, {0, 2}, {1, 1}, {0, -1}, {0, std::int64_t{1} << 62}}) {
    Hdf5Writer file(folder / "m.h5", "nightmap masks", 1, "", "");
    file.WriteList<std::int64_t>("time_ns", {7});
    file.Write("size_px", Array<std::int32_t>{1, 2, {4, 4}});
    file.WriteList("run_offset", offset);
    file.WriteList<std::uint32_t>("run", {16});
    file.Close();
    NIGHTMAP_EXPECT_ERROR(DataError, ReadMasks(folder / "m.h5"), "m.h5: field 'run_offset'");
  }
}

}  // namespace nightmap::masks_io_test
