// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/segmenter.h"

#include <opencv2/core/utility.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "tests/labels/tiny_network.h"

namespace nightmap::segmenter_test {

ColorImage Uniform(int width, int height, const std::array<std::uint8_t, 3>& color) {
  ColorImage image{width, height, 3, {}};
  for (int i = 0; i < width * height; ++i) {
    image.pixels.insert(image.pixels.end(), color.begin(), color.end());
  }
  return image;
}

// Gray with a red disk: a person before a wall.
ColorImage Disk(int width, int height, double radius_px) {
  ColorImage image = Uniform(width, height, {128, 128, 128});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (std::hypot(x - width / 2, y - height / 2) > radius_px) continue;
      image.At(x, y, 0) = 255;
      image.At(x, y, 1) = image.At(x, y, 2) = 0;
    }
  }
  return image;
}

class SegmenterTest : public testing::Test {
 protected:
  SegmenterTest() { cv::setNumThreads(1); }
  SegmentationModel Model() const { return ReadSegmentationModel(WriteTinyModel(folder_)); }
  TemporaryFolder folder_;
};

TEST_F(SegmenterTest, EachPixelGetsItsMostProbableClass) {
  const Segmenter segmenter(Model());
  const std::array<std::array<std::uint8_t, 3>, 3> colors = {
      {{128, 128, 128}, {255, 0, 0}, {0, 0, 255}}};
  for (std::size_t c = 0; c < colors.size(); ++c) {
    const Segmentation result = segmenter.Segment(Uniform(64, 50, colors[c]), {});
    ASSERT_EQ(result.labels.width, 64);
    ASSERT_EQ(result.labels.height, 50);
    EXPECT_THAT(result.labels.pixels, testing::Each(static_cast<std::uint8_t>(c)));
    // Softmax of 3, 0, 0 for gray; of 3, 18, -18 for red and blue.
    EXPECT_THAT(result.confidences.pixels, testing::Each(testing::Ge(c == 0 ? 231 : 254)));
    EXPECT_THAT(result.confidences.pixels, testing::Each(testing::Le(c == 0 ? 233 : 255)));
  }
}

TEST_F(SegmenterTest, ChannelOrderMeanAndScaleAreThoseOfTheModel) {
  SegmentationModel model = Model();
  model.is_bgr = true;
  const ColorImage red = Uniform(40, 30, {255, 0, 0});
  EXPECT_EQ(Segmenter(model).Segment(red, {}).labels.pixels[0], 2);
  model = Model();
  model.mean = {255, 0, 0};
  EXPECT_EQ(Segmenter(model).Segment(red, {}).labels.pixels[0], 0);
  model = Model();
  model.scale = {1e5, 1e5, 1e5};
  EXPECT_EQ(Segmenter(model).Segment(red, {}).labels.pixels[0], 0);
}

TEST_F(SegmenterTest, BordersFollowThePictureBelowTheNetworksResolution) {
  const Segmenter segmenter(Model());
  const ColorImage disk = Disk(640, 480, 150);
  const Segmentation result = segmenter.Segment(disk, {});
  int num_wrong = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      num_wrong += result.labels.At(x, y) != (disk.At(x, y, 1) == 0 ? 1 : 0);
    }
  }
  // A pixel of the network is 16 x 16 pixels wide; the border is 942 px long.
  EXPECT_LT(num_wrong, 942);
}

TEST_F(SegmenterTest, DepthMustHaveTheSizeOfColor) {
  const Segmenter segmenter(Model());
  const DepthImage depth{32, 50, 1, std::vector<float>(32 * 50, 1.0F)};
  NIGHTMAP_EXPECT_ERROR(DataError,
                        segmenter.Segment(Uniform(64, 50, {0, 0, 0}), depth),
                        "depth has 32 x 50 pixels, color 64 x 50");
}

TEST_F(SegmenterTest, ConcurrentCallsGiveWhatSingleOnesGive) {
  const Segmenter segmenter(Model());
  constexpr std::size_t kNum = 12;
  std::vector<ColorImage> pictures;
  for (std::size_t i = 0; i < kNum; ++i) {
    pictures.push_back(Disk(90, 70, 5 + 2 * static_cast<double>(i)));
  }
  const DepthImage depth{90, 70, 1, std::vector<float>(90 * 70, 2.0F)};
  std::vector<Segmentation> results(kNum);
  ParallelFor(kNum, 4, [&](std::size_t i) { results[i] = segmenter.Segment(pictures[i], depth); });
  for (std::size_t i = 0; i < kNum; ++i) {
    const Segmentation alone = segmenter.Segment(pictures[i], depth);
    EXPECT_EQ(alone.labels.pixels, results[i].labels.pixels);
    EXPECT_EQ(alone.confidences.pixels, results[i].confidences.pixels);
  }
}

TEST_F(SegmenterTest, ANetworkThatDoesNotFitTheModelFileIsRefusedAtOnce) {
  const auto path = WriteTinyModel(folder_);
  const auto expect = [&](const std::string& network, const std::string& message) {
    folder_.Write("tiny.onnx", network);
    NIGHTMAP_EXPECT_ERROR(
        UsageError, Segmenter(ReadSegmentationModel(path)), path.string(), message);
  };
  expect("no network", "does not load");
  expect(RedAndBlueNetwork().substr(0, 100), "does not load");
  expect(TinyNetwork(40, 30, std::vector<float>(12), {0, 0, 0}), "does not take one picture");
  expect(TinyNetwork(40, 30, std::vector<float>(6), {0, 0}), "has 2 classes, 'classes' names 3");
}

TEST_F(SegmenterTest, AnOutputOfNoNumbersFailsTheFrame) {
  const auto path = WriteTinyModel(folder_);
  folder_.Write("tiny.onnx", TinyNetwork(40, 30, std::vector<float>(9), {0, NAN, 0}));
  const Segmenter segmenter(ReadSegmentationModel(path));
  NIGHTMAP_EXPECT_ERROR(
      DataError, segmenter.Segment(Uniform(40, 30, {0, 0, 0}), {}), "NaN or infinity");
}

}  // namespace nightmap::segmenter_test
