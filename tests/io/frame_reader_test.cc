// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_reader.h"

#include <mutex>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/masked_pixels.h"
#include "pipeline/io/masks_io.h"
#include "tests/test_data.h"

namespace nightmap::frame_reader_test {

constexpr int kWidth = 40, kHeight = 30;

GrayImage Mask(bool (*is_masked)(int x, int y)) {
  GrayImage mask{kWidth, kHeight, 1, {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) mask.pixels.push_back(is_masked(x, y) ? 255 : 0);
  }
  return mask;
}

GrayImage Disc() {
  return Mask([](int x, int y) { return (x - 18) * (x - 18) + (y - 14) * (y - 14) < 64; });
}

ColorImage Constant(std::uint8_t value) {
  return {kWidth, kHeight, 3, std::vector<std::uint8_t>(kWidth * kHeight * 3, value)};
}

ColorImage Noise(std::uint64_t seed) {
  ColorImage image = Constant(0);
  Random random(seed);
  for (std::uint8_t& value : image.pixels) value = static_cast<std::uint8_t>(random.Index(256));
  return image;
}

TEST(FadeOut, DoesNotDependOnWhatIsMaskedAndKeepsTheRest) {
  ColorImage a = Noise(1);
  ColorImage b = a;
  const ColorImage other = Noise(2);
  const GrayImage mask = Disc();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (mask.At(x, y) != 0) b.At(x, y, 1) = other.At(x, y, 1);
    }
  }
  const ColorImage before = a;
  FadeOut(mask, &a);
  FadeOut(mask, &b);
  EXPECT_EQ(a.pixels, b.pixels);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (mask.At(x, y) == 0) {
        EXPECT_EQ(a.At(x, y, 2), before.At(x, y, 2));
      }
    }
  }
}

// A ramp continues through the hole without steps; a constant stays one.
TEST(FadeOut, ContinuesTheSurroundingsSmoothly) {
  ColorImage constant = Constant(77);
  FadeOut(Disc(), &constant);
  EXPECT_EQ(constant.pixels, Constant(77).pixels);
  ColorImage ramp = Constant(0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool is_hole = Disc().At(x, y) != 0;
      for (int channel = 0; channel < 3; ++channel) {
        ramp.At(x, y, channel) = static_cast<std::uint8_t>(is_hole ? 255 * (x % 2) : 5 * x);
      }
    }
  }
  FadeOut(Disc(), &ramp);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 1; x < kWidth; ++x) EXPECT_NEAR(ramp.At(x, y), ramp.At(x - 1, y), 25) << x;
  }
}

TEST(FadeOut, APictureThatIsAllMaskIsGray) {
  ColorImage image = Noise(3);
  FadeOut(Mask([](int, int) { return true; }), &image);
  EXPECT_EQ(image.pixels, Constant(128).pixels);
}

TEST(FadeOut, AMaskOfAnotherSizeIsRefused) {
  ColorImage image = Noise(3);
  DepthImage depth{kWidth, kHeight, 1, std::vector<float>(kWidth * kHeight, 1)};
  GrayImage mask = Disc();
  std::swap(mask.width, mask.height);
  NIGHTMAP_EXPECT_ERROR(DataError, FadeOut(mask, &image), "30 x 40 pixels and its picture 40 x 30");
  NIGHTMAP_EXPECT_ERROR(DataError, RemoveDepth(mask, &depth), "30 x 40");
}

// Three frames; the masks of the first two are in one file, and nothing is known of the third.
class FrameReaderTest : public testing::Test {
 protected:
  FrameReaderTest() {
    camera_.color = Camera{kWidth, kHeight, 30, 30, 19.5, 14.5};
    for (int i = 0; i < 3; ++i) {
      const std::string name = std::to_string(i) + ".png";
      WritePng(folder_ / ("c" + name), Noise(static_cast<std::uint64_t>(i)));
      WritePng(
          folder_ / ("d" + name),
          RawDepthImage{kWidth, kHeight, 1, std::vector<std::uint16_t>(kWidth * kHeight, 2000)});
      frames_.push_back({i, 10 * i, 0, 0, {"c" + name, "h"}, {"d" + name, "h"}, {}});
      if (i < 2) frames_.back().others[kMaskChannel] = {"shard_0000.h5", "h"};
    }
    WriteMasks(folder_ / "shard_0000.h5",
               {PackMask(0, Disc()), PackMask(10, Mask([](int x, int) { return x < 5; }))},
               "");
  }
  FrameReader Reader() const { return FrameReader(folder_.Path(), {folder_ / "shard_0000.h5"}); }

  TemporaryFolder folder_;
  RgbdCamera camera_;
  std::vector<FrameRecord> frames_;
};

TEST_F(FrameReaderTest, WithoutMaskFilesPixelsAreTheRecordings) {
  const FrameReader reader(folder_.Path());
  for (const FrameRecord& frame : frames_) {
    EXPECT_TRUE(reader.MayUse(frame));
    const RgbdImages images = reader.Rgbd(frame, camera_);
    EXPECT_TRUE(images.moving.pixels.empty());
    EXPECT_EQ(images.color.pixels, LoadColor(frame, camera_, folder_.Path()).pixels);
    EXPECT_EQ(images.depth.pixels, LoadDepth(frame, camera_, folder_.Path()).pixels);
  }
}

TEST_F(FrameReaderTest, TakesTheRobotOutToo) {
  const GrayImage robot = Mask([](int, int y) { return y > 25; });
  camera_.mask = std::make_shared<GrayImage>(robot);
  const RgbdImages images = Reader().Rgbd(frames_[0], camera_);
  for (std::size_t k = 0; k < robot.pixels.size(); ++k) {
    const bool is_out = robot.pixels[k] != 0 || Disc().pixels[k] != 0;
    EXPECT_EQ(images.moving.pixels[k] != 0, is_out) << k;
    EXPECT_EQ(images.depth.pixels[k] == 0, is_out) << k;
  }
}

TEST_F(FrameReaderTest, TakesWhatMovesOutOfColorAndDepth) {
  const FrameReader reader = Reader();
  for (std::size_t i = 0; i < 2; ++i) {
    const RgbdImages images = reader.Rgbd(frames_[i], camera_);
    EXPECT_EQ(images.color.pixels, reader.Color(frames_[i], camera_).pixels);
    EXPECT_EQ(images.depth.pixels, reader.Depth(frames_[i], camera_).pixels);
    ColorImage faded = LoadColor(frames_[i], camera_, folder_.Path());
    FadeOut(images.moving, &faded);
    EXPECT_EQ(images.color.pixels, faded.pixels);
    for (std::size_t k = 0; k < images.depth.pixels.size(); ++k) {
      EXPECT_FLOAT_EQ(images.depth.pixels[k], images.moving.pixels[k] != 0 ? 0.0F : 2.0F);
    }
  }
  EXPECT_EQ(reader.Mask(frames_[0], camera_).pixels, Disc().pixels);
}

TEST_F(FrameReaderTest, AFrameOfWhichNothingIsKnownMayNotBeUsed) {
  EXPECT_TRUE(Reader().MayUse(frames_[1]));
  EXPECT_FALSE(Reader().MayUse(frames_[2]));
  EXPECT_TRUE(Reader().Mask(frames_[2], camera_).pixels.empty());
}

TEST_F(FrameReaderTest, SeveralThreadsReadTheSame) {
  const FrameReader reader = Reader();
  const auto first = reader.Color(frames_[0], camera_).pixels;
  const FrameReader fresh = Reader();
  std::vector<bool> is_equal(16);
  std::mutex mutex;
  ParallelFor(16, 4, [&](std::size_t i) {
    const bool equal = fresh.Color(frames_[0], camera_).pixels == first;
    const std::lock_guard lock(mutex);
    is_equal[i] = equal;
  });
  EXPECT_THAT(is_equal, testing::Each(true));
}

TEST_F(FrameReaderTest, AMaskThatIsMissingOrOfAnotherSizeIsNamed) {
  frames_[0].others[kMaskChannel].path = "shard_0001.h5";
  NIGHTMAP_EXPECT_ERROR(
      ArtifactError, Reader().Color(frames_[0], camera_), "c0.png: its mask is in shard_0001.h5");
  frames_[1].time_ns = 11;
  NIGHTMAP_EXPECT_ERROR(
      ArtifactError, Reader().Depth(frames_[1], camera_), "shard_0000.h5: has no mask of frame c1");
  std::swap(camera_.color.width, camera_.color.height);
  frames_[1].time_ns = 10;
  NIGHTMAP_EXPECT_ERROR(ArtifactError,
                        Reader().Mask(frames_[1], camera_),
                        "shard_0000.h5: the mask of c1.png is 40 x 30 pixels and its picture 30");
}

// It says so each time, not that it lacks the frame.
TEST_F(FrameReaderTest, ADamagedFileOfMasksIsNoFailureOfAPicture) {
  std::filesystem::resize_file(folder_ / "shard_0000.h5", 600);
  const FrameReader reader = Reader();
  for (int i = 0; i < 2; ++i) {
    const auto read = [&] {
      std::ignore = FrameFailure("c0.png", [&] { reader.Color(frames_[0], camera_); });
    };
    NIGHTMAP_EXPECT_ERROR(ArtifactError, read(), "shard_0000.h5: not a readable HDF5 file");
  }
}

}  // namespace nightmap::frame_reader_test
