// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/error.h"
#include "tests/io/some_frames.h"
#include "tests/test_data.h"

namespace nightmap::cameras_io_test {

RgbdCamera FisheyeCamera() {
  RgbdCamera camera = SomeCamera();
  camera.color.lens = Lens::kFisheye;
  camera.color.p1 = camera.color.p2 = 0;
  return camera;
}

class CamerasJson : public testing::Test {
 protected:
  std::vector<RgbdCamera> Read(const std::string& json) const {
    return ReadCameras(folder_.Write("cameras.json", json));
  }
  // The text with one part replaced is refused, by name.
  void ExpectRefused(std::string text,
                     const std::string& from,
                     const std::string& to,
                     const std::string& why) const {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(text), why, "cameras.json");
  }

  TemporaryFolder folder_;
};

TEST_F(CamerasJson, WhatIsWrittenIsRead) {
  RgbdCamera second = UnregisteredCamera();
  second.camera_id = "second \"camera\"";
  second.color_from_depth = {Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3).normalized(), {0.1, 0.2, -3}};
  const auto read = Read(CamerasToJson({SomeCamera(), second}));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].color.k3, 0.05);
  EXPECT_EQ(read[0].noise.quadratic_per_m, 0.003);
  EXPECT_EQ(read[1].depth.width, 40);
  EXPECT_FALSE(read[1].depth_registered);
  EXPECT_LT(AngleBetween_rad(read[1].color_from_depth, second.color_from_depth), 1e-9);
  EXPECT_EQ(CamerasToJson(Read(CamerasToJson(read))), CamerasToJson(read));
}

TEST_F(CamerasJson, WhatOnlyLaterProgramsKnowRaisesTheVersion) {
  const std::string plain = CamerasToJson({SomeCamera()});
  EXPECT_THAT(plain, testing::HasSubstr("\"version\": 1"));
  const auto expect = [&](int version, const std::string& text, const auto& change) {
    SCOPED_TRACE(text);
    RgbdCamera changed = SomeCamera();
    change(changed);
    const std::string json = CamerasToJson({SomeCamera(), changed});
    EXPECT_THAT(plain, testing::Not(testing::HasSubstr(text.substr(0, text.find(':')))));
    EXPECT_THAT(json, testing::HasSubstr(fmt::format("\"version\": {}", version)));
    EXPECT_THAT(json, testing::HasSubstr(text));
    const auto read = Read(json);
    EXPECT_EQ(CamerasToJson({read.at(0)}), plain);
    EXPECT_TRUE(read[0].IsCalibrated());
    EXPECT_EQ(CamerasToJson(read), json);
    EXPECT_EQ(read.at(1).color, changed.color);
    EXPECT_EQ(read[1].Picture(), changed.Picture());
  };
  expect(2, "\"focal_sigma_ratio\": 0.15", [](auto& c) { c.focal_sigma_ratio = 0.15; });
  expect(3, "\"depth_along_ray\": true", [](auto& c) { c.depth_along_ray = true; });
  expect(3, "\"mask_runs\": [", [](auto& c) { c.mask = MaskedCamera().mask; });
  expect(4, "\"min_confidence\": 2", [](auto& c) { c.min_confidence = 2; });
  expect(4, "\"depth_offset_m\": 2.5", [](auto& c) { c.depth_offset_m = 2.5; });
  expect(4, "\"picture_bits\": 10", [](auto& c) { c.picture_bits = 10; });
  expect(5, "\"picture_width\": 80", [](auto& c) { c = ReducedCamera(); });
  expect(5, "\"k4\": 0.25", [](auto& c) {
    c.color.k4 = 0.25;
    c.color.k5 = -0.5;
    c.color.k6 = 0.125;
  });
  expect(5, "\"lens\": \"fisheye\"", [](auto& c) { c = FisheyeCamera(); });
  EXPECT_EQ(Read(CamerasToJson({MaskedCamera()})).at(0).mask->pixels, MaskedCamera().mask->pixels);
}

TEST_F(CamerasJson, DamagedMasksAreRefused) {
  for (const std::string wrong : {"82", "84", "-83", "83.5", "4294967379", "\"a\"", "83, 0"}) {
    ExpectRefused(CamerasToJson({MaskedCamera()}), " 83,", " " + wrong + ",", ": mask_runs");
  }
}

TEST_F(CamerasJson, EveryFrameMustHaveItsCamera) {
  const auto path = folder_.Write("cameras.json", CamerasToJson({SomeCamera(), SomeCamera()}));
  auto frames = SomeFrames(7, 2);
  frames[0].camera_idx = 1;
  frames[1].camera_idx = 0;
  EXPECT_EQ(ReadCameras(path, frames).size(), 2u);
  for (const int camera_idx : {2, -1}) {
    frames[1].camera_idx = camera_idx;
    NIGHTMAP_EXPECT_ERROR(DataError,
                          ReadCameras(path, frames),
                          path.string() + ": has 2 cameras, but frame 8 (" + frames[1].color.path);
  }
}

TEST_F(CamerasJson, DamageIsRefused) {
  const std::string text = CamerasToJson({SomeCamera(), UnregisteredCamera()});
  for (std::size_t length = 0; length + 3 < text.size(); length += 5) {
    ASSERT_THROW(Read(text.substr(0, length)), DataError);
  }
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& why) {
    ExpectRefused(text, from, to, why);
  };
  expect("\"version\": 1", "\"version\": 1000", "newer");
  expect("nightmap cameras", "other", "format");
  expect("\"fx\": 35.25", "\"fx\": 0", "fx");
  expect("\"fx\": 35.25", "\"fx\": \"wide\"", "type");
  expect("\"fx\": 35.25", "\"fx\": null", "type");
  expect("\"fx\": 35.25,", "", "fx");
  for (const std::string wrong : {"0", "-40", "40.5", "32769", "4294967336", "1e300"}) {
    expect("\"width\": 40", "\"width\": " + wrong, "width is");
  }
  expect("\"depth_noise_constant_m\": 0.001",
         "\"depth_noise_constant_m\": 0.0",
         "depth_noise_constant_m is 0, must be at least 1e-05: correct it in the site config");
  expect("\"depth_noise_quadratic_per_m\": 0.003",
         "\"depth_noise_quadratic_per_m\": -0.003",
         "depth_noise_quadratic_per_m is -0.003, must be at least 0");
  ExpectRefused(CamerasToJson({FisheyeCamera()}), "\"fisheye\"", "\"fishy\"", "lens is 'fishy'");
  ExpectRefused(CamerasToJson({ReducedCamera()}),
                "\"picture_width\": 80",
                "\"picture_width\": 39",
                "picture_width");
}

TEST(ReduceToWorkingSize, KeepsTheLensAndRemembersThePicture) {
  const RgbdCamera camera = ReducedCamera();
  EXPECT_EQ(camera.color.width, 40);
  EXPECT_EQ(camera.color.height, 30);
  EXPECT_DOUBLE_EQ(camera.color.fx, 35);
  EXPECT_DOUBLE_EQ(camera.color.cx, (41 + 0.5) / 2 - 0.5);
  EXPECT_EQ(camera.Picture(), (Camera{80, 60, 70, 70, 41, 29}));
  RgbdCamera same = SomeCamera();
  ReduceToWorkingSize(1200e-6, &same);  // it has as many
  EXPECT_EQ(same.picture_width, 0);
  EXPECT_EQ(same.Picture(), SomeCamera().color);
  RgbdCamera line = SomeCamera();
  line.color.width = 1200;
  line.color.height = 1;
  ReduceToWorkingSize(1e-6, &line);
  EXPECT_EQ(line.color.height, 1);
}

}  // namespace nightmap::cameras_io_test
