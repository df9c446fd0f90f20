// SPDX-License-Identifier: Apache-2.0
// Depth pictures of floating-point values, as frames_io.h reads them.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/frames_io.h"
#include "tests/test_data.h"

namespace nightmap::float_depth_test {

constexpr int kWidth = 40;
constexpr int kHeight = 30;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNone[] = {0, -1, kInfinity, -kInfinity, NAN, 65535};

RgbdCamera FloatCamera() {
  RgbdCamera camera;
  camera.color = {.width = kWidth, .height = kHeight, .fx = 35, .fy = 35, .cx = 19.5, .cy = 14.5};
  camera.depth_units_per_m = 0;
  camera.min_depth_m = 0.25;
  camera.max_depth_m = 4.5;
  return camera;
}

// In metres: no value of kNone, then those from 0 m on in steps of 1/256 m, which a half float has.
std::vector<float> SomeDepth() {
  std::vector<float> depth_m(kNone, std::end(kNone));
  while (depth_m.size() < kWidth * kHeight) {
    depth_m.push_back(static_cast<float>(depth_m.size()) / 256);
  }
  return depth_m;
}

void WriteFloats(const std::filesystem::path& path,
                 OIIO::TypeDesc type,
                 const std::vector<float>& depth,
                 int num_channels = 1) {
  const OIIO::ImageSpec spec(kWidth, kHeight / num_channels, num_channels, type);
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output && output->open(path.string(), spec) &&
              output->write_image(OIIO::TypeDesc::FLOAT, depth.data()) && output->close())
      << path;
}

class FloatDepthTest : public testing::Test {
 protected:
  DepthImage Load(const std::string& name, const RgbdCamera& camera = FloatCamera()) const {
    FrameRecord frame;
    frame.depth.path = name;
    return LoadDepth(frame, camera, folder_.Path());
  }

  TemporaryFolder folder_;
};

TEST_F(FloatDepthTest, IsInMetresAndOnlyPositiveNumbersAreMeasured) {
  const std::pair<const char*, OIIO::TypeDesc> kinds[] = {{"half.exr", OIIO::TypeDesc::HALF},
                                                          {"float.exr", OIIO::TypeDesc::FLOAT},
                                                          {"float.tif", OIIO::TypeDesc::FLOAT},
                                                          {"double.tif", OIIO::TypeDesc::DOUBLE}};
  const std::vector<float> written = SomeDepth();
  for (const auto& [name, type] : kinds) {
    WriteFloats(folder_ / name, type, written);
    EXPECT_TRUE(InspectImage(folder_ / name).is_float) << name;
    const DepthImage depth = Load(name);
    for (std::size_t i = 0; i < written.size(); ++i) {
      const bool is_measured = i >= std::size(kNone) && written[i] >= 0.25 && written[i] <= 4.5;
      ASSERT_EQ(depth.pixels[i], is_measured ? written[i] : 0) << name << " " << i;
    }
  }
}

TEST_F(FloatDepthTest, AStatedUnitHolds) {
  std::vector<float> depth = SomeDepth();
  WriteFloats(folder_ / "m.tif", OIIO::TypeDesc::FLOAT, depth);
  for (float& value : depth) value *= 1024;
  WriteFloats(folder_ / "units.tif", OIIO::TypeDesc::FLOAT, depth);
  RgbdCamera camera = FloatCamera();
  camera.depth_units_per_m = 1024;
  EXPECT_EQ(Load("units.tif", camera).pixels, Load("m.tif").pixels);
  const auto read = ReadCameras(folder_.Write("cameras.json", CamerasToJson({FloatCamera()})));
  EXPECT_EQ(read.at(0).depth_units_per_m, 0);
}

TEST_F(FloatDepthTest, IsTheDepthOfIntegersWithinHalfAUnit) {
  RawDepthImage raw{kWidth, kHeight, 1, {}};
  std::vector<float> depth_m;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    depth_m.push_back(0.3f + 0.0031f * static_cast<float>(i));
    raw.pixels.push_back(static_cast<std::uint16_t>(std::lround(5000 * depth_m.back())));
  }
  WritePng(folder_ / "d.png", raw);
  WriteFloats(folder_ / "d.tif", OIIO::TypeDesc::FLOAT, depth_m);
  RgbdCamera camera = FloatCamera();
  const DepthImage of_floats = Load("d.tif");
  camera.depth_units_per_m = 5000;
  const DepthImage of_integers = Load("d.png", camera);
  for (std::size_t i = 0; i < of_floats.pixels.size(); ++i) {
    ASSERT_NEAR(of_floats.pixels[i], of_integers.pixels[i], 1.01e-4) << i;
  }
}

TEST_F(FloatDepthTest, OtherSizesAndChannelsAreRefused) {
  const std::vector<float> values(kWidth * kHeight, 1.0f);
  WriteFloats(folder_ / "three.exr", OIIO::TypeDesc::FLOAT, values, 3);
  NIGHTMAP_EXPECT_ERROR(DataError, Load("three.exr"), "three.exr: depth must be one channel of");
  WriteFloats(folder_ / "a.tif", OIIO::TypeDesc::FLOAT, values);
  RgbdCamera camera = FloatCamera();
  camera.color.width = 2 * kWidth;
  NIGHTMAP_EXPECT_ERROR(DataError, Load("a.tif", camera), "a.tif: 40 x 30 pixels, its camera has");
}

TEST_F(FloatDepthTest, ATruncatedFileIsNamedWithTheRemedy) {
  for (const std::string name : {"a.tif", "a.exr"}) {
    WriteFloats(folder_ / name, OIIO::TypeDesc::FLOAT, SomeDepth());
    const std::string whole = ReadBytes(folder_ / name);
    for (const double share : {0.1, 0.5, 0.9, 0.99}) {
      const auto size = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
      folder_.Write("cut_" + name, whole.substr(0, size));
      NIGHTMAP_EXPECT_ERROR(DataError, Load("cut_" + name), "cut_" + name, "copy it again");
    }
  }
}

TEST_F(FloatDepthTest, ADamagedFileIsReadOrRefused) {
  Random random(7, 0);
  int num_refused = 0;
  for (const std::string name : {"a.tif", "a.exr"}) {
    WriteFloats(folder_ / name, OIIO::TypeDesc::FLOAT, SomeDepth());
    const std::string whole = ReadBytes(folder_ / name);
    for (int i = 0; i < 100; ++i) {
      std::string damaged = whole;
      for (int k = 0; k < 8; ++k) {
        damaged[random.Index(i % 2 ? damaged.size() : 400)] = static_cast<char>(random.Index(256));
      }
      folder_.Write("damaged", damaged);
      try {
        for (const float depth_m : Load("damaged").pixels) {
          ASSERT_TRUE(depth_m == 0 || (depth_m >= 0.25f && depth_m <= 4.5f)) << name << " " << i;
        }
      } catch (const DataError& error) {
        EXPECT_THAT(error.what(), testing::StartsWith("damaged: "));
        ++num_refused;
      }
    }
  }
  EXPECT_GE(num_refused, 20);
}

}  // namespace nightmap::float_depth_test
