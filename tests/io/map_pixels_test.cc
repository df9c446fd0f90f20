// SPDX-License-Identifier: Apache-2.0
// Pictures of ROS maps: what map_server (Nav2) makes of each kind.
#include <fmt/format.h>

#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/grid_io.h"
#include "tests/test_data.h"

namespace nightmap::map_pixels_test {

// 4 x 1 pixels of two bits, indices 0 to 3 of the grays 0, 205, 254, 255; written by Pillow.
constexpr std::string_view kPalettePng(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x04"
    "\x00\x00\x00\x01\x02\x03\x00\x00\x00\x84\x52\xE7\x5E\x00\x00\x00\x0C\x50\x4C\x54"
    "\x45\x00\x00\x00\xCD\xCD\xCD\xFE\xFE\xFE\xFF\xFF\xFF\x8E\x93\xAE\xF7\x00\x00\x00"
    "\x0A\x49\x44\x41\x54\x78\x9C\x63\x90\x06\x00\x00\x1D\x00\x1C\x8E\xF4\xF5\x21\x00"
    "\x00\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    91);

class MapPixelsTest : public testing::Test {
 protected:
  // Writes a row of pixels as a PNG.
  template <typename T>
  void WritePixels(int num_channels, const std::vector<T>& values) const {
    Image<T> image{static_cast<int>(values.size()) / num_channels, 1, num_channels, values};
    WritePng(folder_.Path() / "map.png", image);
  }
  std::vector<std::uint8_t> Read(const std::string& name,
                                 const std::string& mode,
                                 double free_thresh = 0.196,
                                 int negate = 0) const {
    const auto path = folder_.Path() / "map.yaml";
    WriteFile(path,
              fmt::format("image: {}\nmode: {}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: {}\n"
                          "occupied_thresh: 0.65\nfree_thresh: {}\n",
                          name,
                          mode,
                          negate,
                          free_thresh));
    return ReadGrid(path).cells;
  }
  std::vector<std::uint8_t> ReadPgm(const std::string& bytes) const {
    WriteFile(folder_.Path() / "map.pgm", bytes);
    return Read("map.pgm", "trinary");
  }

  TemporaryFolder folder_;
};

using Cells = std::vector<std::uint8_t>;
const Cells kSeen = {kOccupiedCell, kUnknownCell, kFreeCell, kFreeCell};  // 0, 205, 254, 255

TEST_F(MapPixelsTest, AllKindsOfPgmAreOneMap) {
  using namespace std::string_literals;
  EXPECT_EQ(ReadPgm("P5\n# CREATOR: another program\n4 1\n255\n\x00\xCD\xFE\xFF"s), kSeen);
  EXPECT_EQ(ReadPgm("P2\n# CREATOR: another program\n4 1\n255\n0 205 254\n255\n"), kSeen);
  EXPECT_EQ(ReadPgm("P5\n4 1\n65535\n\x00\x00\xCD\xCD\xFE\xFE\xFF\xFF"s), kSeen);
  EXPECT_EQ(ReadPgm("P2\n4 1\n65535\n0 52685 65278 65535\n"), kSeen);
  EXPECT_EQ(ReadPgm("P5\n4 1\n100\n\x00\x50\x63\x64"s), kSeen);
  EXPECT_EQ(ReadPgm("P2\n4 1\n1000\n0 800 995 1000\n"), kSeen);
}

TEST_F(MapPixelsTest, AllKindsOfPngAreOneMap) {
  WritePixels<std::uint8_t>(1, {0, 205, 254, 255});
  EXPECT_EQ(Read("map.png", "trinary"), kSeen);
  WritePixels<std::uint16_t>(1, {0, 52685, 65278, 65535});
  EXPECT_EQ(Read("map.png", "trinary"), kSeen);
  WritePixels<std::uint8_t>(3, {0, 0, 0, 255, 255, 105, 254, 254, 254, 255, 255, 255});
  EXPECT_EQ(Read("map.png", "trinary"), kSeen);
  WritePixels<std::uint16_t>(3, {0, 0, 0, 52685, 52600, 52700, 65278, 65278, 65278, 9, 9, 9});
  EXPECT_EQ(Read("map.png", "trinary"), (Cells{1, 2, 0, 1}));
}

// Mode trinary takes the mean of colors and alpha, of gray as of RGB: an opaque wall is a quarter
// free. The other modes take that of the colors; in mode scale what is not opaque is unknown.
TEST_F(MapPixelsTest, AlphaCountsAsMapServerCountsIt) {
  for (const int num_colors : {1, 3}) {
    const std::vector<std::pair<int, int>> grays_and_alphas = {
        {0, 255}, {0, 0}, {205, 255}, {205, 0}, {254, 255}, {254, 254}, {254, 0}};
    std::vector<std::uint8_t> values;
    for (const auto& [gray, alpha] : grays_and_alphas) {
      values.insert(
          values.end(), static_cast<std::size_t>(num_colors), static_cast<std::uint8_t>(gray));
      values.push_back(static_cast<std::uint8_t>(alpha));
    }
    WritePixels<std::uint8_t>(num_colors + 1, values);
    EXPECT_EQ(Read("map.png", "trinary"), (Cells{1, 1, 0, 2, 0, 0, 2}));
    EXPECT_EQ(Read("map.png", "scale"), (Cells{1, 2, 2, 2, 0, 2, 2}));
    EXPECT_EQ(Read("map.png", "raw"), (Cells{0, 0, 2, 2, 2, 2, 2}));
  }
}

// The colors of a palette count, not the indices.
TEST_F(MapPixelsTest, PaletteStandsForItsColors) {
  WriteFile(folder_.Path() / "map.png", std::string(kPalettePng));
  EXPECT_EQ(Read("map.png", "trinary"), kSeen);
  for (std::size_t size = 0; size < kPalettePng.size(); ++size) {
    WriteFile(folder_.Path() / "map.png", kPalettePng.substr(0, size));
    EXPECT_THROW(Read("map.png", "trinary"), DataError) << size;
  }
}

TEST_F(MapPixelsTest, ThresholdsThatTakeUnseenSpaceForFreeAreWarnedOf) {
  const auto said = [&](double free_thresh, int negate) {
    testing::internal::CaptureStdout();
    Read("map.png", "trinary", free_thresh, negate);
    return testing::internal::GetCapturedStdout();
  };
  const std::string warning = "map.yaml: 2 cells of the gray that map_saver gives to unseen space";
  WritePixels<std::uint8_t>(1, {0, 205, 254, 205, 204, 206});
  EXPECT_THAT(said(0.25, 0), testing::HasSubstr(warning));
  EXPECT_THAT(said(0.25, 0), testing::HasSubstr("write free_thresh: 0.196\n"));
  EXPECT_EQ(said(0.196, 0), "");
  EXPECT_EQ(said(0.25, 1), "");
  WritePixels<std::uint8_t>(1, {255, 50, 0, 50, 51, 49});
  EXPECT_THAT(said(0.25, 1), testing::HasSubstr(warning));
  EXPECT_EQ(said(0.196, 1), "");
  WritePixels<std::uint8_t>(2, {0, 255, 205, 255, 254, 255, 205, 255});
  EXPECT_THAT(said(0.196, 0), testing::HasSubstr("save the picture without alpha"));
  WritePixels<std::uint8_t>(1, {0, 254, 230, 180});
  EXPECT_EQ(said(0.25, 0), "");
}

}  // namespace nightmap::map_pixels_test
