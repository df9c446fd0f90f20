// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frames_io.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap {
namespace frames_io_test {

std::vector<FrameRecord> SomeFrames(int first_idx, int count) {
  std::vector<FrameRecord> frames;
  for (int i = first_idx; i < first_idx + count; ++i) {
    frames.push_back({.frame_idx = i,
                      .time_ns = 1305031102175304000 + i,
                      .camera_idx = i % 3,
                      .sequence_idx = i / 10,
                      .color = {"site/a, \"b\" " + std::to_string(i) + ".png", "0123456789abcdef"},
                      .depth = i % 2 ? ChannelFile{} : ChannelFile{"site/depth.png", "ab"},
                      .others = {}});
  }
  return frames;
}

RgbdCamera SomeCamera() {
  RgbdCamera camera;
  camera.camera_id = "color";
  camera.color = {.width = 40,
                  .height = 30,
                  .fx = 35.25,
                  .fy = 36.1,
                  .cx = 19.5,
                  .cy = 14.5,
                  .k1 = 0.1,
                  .k2 = -0.2,
                  .p1 = 0.001,
                  .p2 = -0.002,
                  .k3 = 0.05};
  camera.depth_units_per_m = 5000;
  camera.min_depth_m = 0.3;
  camera.max_depth_m = 4.5;
  camera.noise = {.constant_m = 0.001, .quadratic_per_m = 0.003};
  return camera;
}

// Depth camera with other intrinsics and pose than the color camera; no distortion.
RgbdCamera UnregisteredCamera() {
  RgbdCamera camera = SomeCamera();
  camera.color = {.width = 80, .height = 60, .fx = 70, .fy = 70, .cx = 39.5, .cy = 29.5};
  camera.depth = {.width = 40, .height = 30, .fx = 35, .fy = 35, .cx = 19.5, .cy = 14.5};
  camera.depth_registered = false;
  return camera;
}

DepthImage Plane(const Camera& camera, float depth_m) {
  const auto num_pixels = static_cast<std::size_t>(camera.width * camera.height);
  return {camera.width, camera.height, 1, std::vector<float>(num_pixels, depth_m)};
}

TEST(FramesCsv, WhatIsWrittenIsRead) {
  const TemporaryFolder folder;
  const auto frames = SomeFrames(5, 20);
  const auto read = ReadFrames(folder.Write("a.csv", FramesToCsv(frames)));
  ASSERT_EQ(read.size(), frames.size());
  EXPECT_EQ(FramesToCsv(read), FramesToCsv(frames));
  EXPECT_EQ(read[7].color.path, frames[7].color.path);
  EXPECT_EQ(read[7].time_ns, frames[7].time_ns);
  EXPECT_TRUE(ReadFrames(folder.Write("empty.csv", FramesToCsv({}))).empty());
}

TEST(FramesCsv, AnotherChannelNeedsNoReaderAndChangesNoListWithoutIt) {
  const TemporaryFolder folder;
  auto frames = SomeFrames(0, 4);
  const std::string before = FramesToCsv(frames);
  frames[2].others["label"] = {"site/labels/2.png", "cd"};
  frames[3].others["thermal"] = {"site/heat, 3.tif", "ef"};
  const auto read = ReadFrames(folder.Write("a.csv", FramesToCsv(frames)));
  EXPECT_TRUE(read[0].others.empty());
  EXPECT_EQ(read[2].others.at("label").path, "site/labels/2.png");
  EXPECT_EQ(read[2].others.count("thermal"), 0u);
  EXPECT_EQ(read[3].others.at("thermal").path, "site/heat, 3.tif");
  EXPECT_EQ(FramesToCsv(read), FramesToCsv(frames));
  frames[2].others.clear();
  frames[3].others.clear();
  EXPECT_EQ(FramesToCsv(frames), before);
}

TEST(FramesCsv, ChannelsOfTheHeaderAreChecked) {
  const TemporaryFolder folder;
  const std::string header = FramesToCsv({}).substr(0, FramesToCsv({}).size() - 1);
  for (const char* more : {",label_path",
                           ",label_hash,label_path",
                           ",label_path,other_hash",
                           ",_path,_hash",
                           ",color_path,color_hash",
                           ",label_path,label_hash,label_path,label_hash",
                           ",x,y"}) {
    NIGHTMAP_EXPECT_ERROR(
        DataError, ReadFrames(folder.Write("h.csv", header + more + "\n")), "h.csv:1: column '");
  }
}

TEST(FramesCsv, ShardsMustFollowEachOther) {
  const TemporaryFolder folder;
  const auto a = folder.Write("a.csv", FramesToCsv(SomeFrames(0, 4)));
  const auto b = folder.Write("b.csv", FramesToCsv(SomeFrames(4, 3)));
  EXPECT_EQ(ReadFrames(std::vector{a, b}).size(), 7u);
  // Either may be the damaged one, so both are named.
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadFrames(std::vector{b, a}),
                        a.string() + " starts with frame 0, but " + b.string() +
                            ", the list before it, ends with frame 6");
  const auto empty = folder.Write("empty.csv", FramesToCsv({}));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadFrames(std::vector{a, empty}), "empty.csv: lists no frame");
}

TEST(FramesCsv, APictureIsOneFrame) {
  const TemporaryFolder folder;
  auto frames = SomeFrames(4, 3);
  frames[2].color.path = SomeFrames(0, 4)[1].color.path;
  const auto a = folder.Write("a.csv", FramesToCsv(SomeFrames(0, 4)));
  const auto b = folder.Write("b.csv", FramesToCsv(frames));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadFrames(std::vector{a, b}), "b.csv: frame 6 has the picture");
}

TEST(FramesCsv, BadLinesAreNamed) {
  const TemporaryFolder folder;
  const std::string header = FramesToCsv({});
  const auto expect = [&](const std::string& line, const std::string& reason) {
    const auto path = folder.Write("bad.csv", header + "0,1,0,0,a,ff,b,ee\n" + line + "\n");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFrames(path), "bad.csv:3: " + reason);
  };
  expect("1,2,0,0,a,ff,b", "7 fields, expected 8");
  expect("1,2,0,0,a,ff,b,ee,x", "9 fields");
  expect("1,2.5,0,0,a,ff,b,ee", "time_ns is '2.5', not an integer");
  expect("1,,0,0,a,ff,b,ee", "time_ns is '', not an integer");
  expect("1,2,-1,0,a,ff,b,ee", "camera_idx is -1, out of range");
  expect("1,2,99999999999,0,a,ff,b,ee", "camera_idx is 99999999999, out of range");
  expect("1,2,0,0,,,b,ee", "color_path is empty");
  expect("1,2,0,0,a,,b,ee", "color_hash is empty");
  expect("1,2,0,0,a,ff,,ee", "depth_path is empty");
  expect("1,2,0,0,a,ff,b,", "depth_hash is empty");
  expect("3,2,0,0,a,ff,b,ee", "frame_idx must count up by one");
  expect("1,2,0,0,\"a,ff,b,ee", "a quote");
  expect("", "1 fields");
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadFrames(folder.Write("h.csv", "frame_idx\n0\n")), "h.csv:1: the header");
}

TEST(FramesCsv, TruncationIsRefusedAtEveryLengthWithinALine) {
  const TemporaryFolder folder;
  const std::string text = FramesToCsv(SomeFrames(0, 3));
  for (std::size_t length = 0; length < text.size(); ++length) {
    if (length > 0 && text[length - 1] == '\n') continue;
    ASSERT_THROW(ReadFrames(folder.Write("cut.csv", text.substr(0, length))), DataError) << length;
  }
}

TEST(CamerasJson, WhatIsWrittenIsRead) {
  const TemporaryFolder folder;
  RgbdCamera second = UnregisteredCamera();
  second.camera_id = "second \"camera\"";
  second.color_from_depth = {Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3).normalized(), {0.1, 0.2, -3}};
  const std::string text = CamerasToJson({SomeCamera(), second});
  const auto read = ReadCameras(folder.Write("cameras.json", text));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].color.k3, 0.05);
  EXPECT_EQ(read[0].noise.quadratic_per_m, 0.003);
  EXPECT_EQ(read[1].depth.width, 40);
  EXPECT_FALSE(read[1].depth_registered);
  EXPECT_LT(AngleBetween_rad(read[1].color_from_depth, second.color_from_depth), 1e-9);
  EXPECT_EQ(CamerasToJson(ReadCameras(folder.Write("again.json", CamerasToJson(read)))),
            CamerasToJson(read));
}

TEST(CamerasJson, AnUncertainFocalLengthNeedsAProgramThatKnowsIt) {
  const TemporaryFolder folder;
  RgbdCamera uncertain = SomeCamera();
  uncertain.focal_sigma_ratio = 0.15;
  const std::string text = CamerasToJson({SomeCamera(), uncertain});
  const auto read = ReadCameras(folder.Write("cameras.json", text));
  EXPECT_TRUE(read.at(0).IsCalibrated());
  EXPECT_EQ(read.at(1).focal_sigma_ratio, 0.15);
  EXPECT_NE(text.find("\"version\": 2"), std::string::npos);
  EXPECT_NE(CamerasToJson({SomeCamera()}).find("\"version\": 1"), std::string::npos);
}

TEST(CamerasJson, ALensOfAnotherModelNeedsAProgramThatKnowsIt) {
  const TemporaryFolder folder;
  RgbdCamera fisheye = SomeCamera();
  fisheye.color.lens = Lens::kFisheye;
  fisheye.color.p1 = fisheye.color.p2 = 0;
  RgbdCamera rational = SomeCamera();
  rational.color.k4 = 0.25;
  rational.color.k5 = -0.5;
  rational.color.k6 = 0.125;
  for (const RgbdCamera& camera : {fisheye, rational}) {
    const std::string text = CamerasToJson({SomeCamera(), camera});
    EXPECT_NE(text.find("\"version\": 5"), std::string::npos);
    const auto read = ReadCameras(folder.Write("cameras.json", text));
    EXPECT_EQ(read.at(0).color, SomeCamera().color);
    EXPECT_EQ(read.at(1).color, camera.color);
  }
  EXPECT_EQ(CamerasToJson({SomeCamera()}).find("k4"), std::string::npos);
  std::string text = CamerasToJson({fisheye});
  text.replace(text.find("\"fisheye\""), 9, "\"fishy\"");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadCameras(folder.Write("bad.json", text)), "lens is 'fishy'");
}

RgbdCamera MaskedCamera() {
  RgbdCamera camera = SomeCamera();
  GrayImage mask{40, 30, 1, std::vector<std::uint8_t>(1200, 0)};
  std::fill(mask.pixels.begin() + 1000, mask.pixels.end(), std::uint8_t{255});
  mask.At(3, 2) = 255;
  camera.mask = std::make_shared<GrayImage>(mask);
  return camera;
}

TEST(CamerasJson, AMaskNeedsAProgramThatKnowsIt) {
  const TemporaryFolder folder;
  const std::string text = CamerasToJson({SomeCamera(), MaskedCamera()});
  EXPECT_NE(text.find("\"version\": 3"), std::string::npos);
  const auto read = ReadCameras(folder.Write("cameras.json", text));
  EXPECT_EQ(read.at(0).mask, nullptr);
  ASSERT_NE(read.at(1).mask, nullptr);
  EXPECT_EQ(read[1].mask->width, 40);
  EXPECT_EQ(read[1].mask->pixels, MaskedCamera().mask->pixels);
  EXPECT_EQ(CamerasToJson(read), text);
}

TEST(CamerasJson, DamagedMasksAreRefused) {
  const TemporaryFolder folder;
  const std::string text = CamerasToJson({MaskedCamera()});
  for (const std::string wrong : {"82", "84", "-83", "83.5", "4294967379", "\"a\"", "83, 0"}) {
    std::string changed = text;
    ASSERT_NE(changed.find(" 83,"), std::string::npos);
    changed.replace(changed.find(" 83,"), 4, " " + wrong + ",");
    NIGHTMAP_EXPECT_ERROR(
        DataError, ReadCameras(folder.Write("cameras.json", changed)), "cameras.json: mask_runs");
  }
}

TEST(CamerasJson, EveryFrameMustHaveItsCamera) {
  const TemporaryFolder folder;
  const auto path = folder.Write("cameras.json", CamerasToJson({SomeCamera(), SomeCamera()}));
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

TEST(CamerasJson, DamageIsRefused) {
  const TemporaryFolder folder;
  const std::string text = CamerasToJson({SomeCamera(), UnregisteredCamera()});
  for (std::size_t length = 0; length + 3 < text.size(); length += 5) {
    ASSERT_THROW(ReadCameras(folder.Write("cut.json", text.substr(0, length))), DataError);
  }
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& why) {
    std::string changed = text;
    ASSERT_NE(changed.find(from), std::string::npos) << from;
    changed.replace(changed.find(from), from.size(), to);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadCameras(folder.Write("bad.json", changed)), why);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadCameras(folder / "bad.json"), "bad.json");
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
}

TEST(LoadDepth, IsInMetresWithinTheRange) {
  const TemporaryFolder folder;
  const RgbdCamera camera = SomeCamera();
  RawDepthImage raw{40, 30, 1, std::vector<std::uint16_t>(1200, 10000)};
  raw.At(1, 0) = 0;
  raw.At(2, 0) = 65535;
  raw.At(3, 0) = 1499;   // 0.2998 m, too near
  raw.At(4, 0) = 22501;  // 4.5002 m, too far
  raw.At(5, 0) = 22500;
  WritePng(folder / "d.png", raw);
  FrameRecord frame;
  frame.depth.path = "d.png";
  const DepthImage depth = LoadDepth(frame, camera, folder.Path());
  EXPECT_FLOAT_EQ(depth.At(0, 0), 2.0f);
  for (int x = 1; x <= 4; ++x) EXPECT_EQ(depth.At(x, 0), 0.0f) << x;
  EXPECT_FLOAT_EQ(depth.At(5, 0), 4.5f);
}

TEST(LoadDepth, DistancesAlongTheRayBecomeZ) {
  const TemporaryFolder folder;
  RgbdCamera camera = SomeCamera();
  RawDepthImage raw{40, 30, 1, std::vector<std::uint16_t>(1200)};
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double ray = camera.color.BackProject(Eigen::Vector2d(x, y), 2.0).norm();
      raw.At(x, y) = static_cast<std::uint16_t>(std::lround(ray * camera.depth_units_per_m));
    }
  }
  WritePng(folder / "d.png", raw);
  FrameRecord frame;
  frame.depth.path = "d.png";
  EXPECT_GT(LoadDepth(frame, camera, folder.Path()).At(0, 0), 2.1f);
  camera.depth_along_ray = true;
  const DepthImage depth = LoadDepth(frame, camera, folder.Path());
  for (const float z : depth.pixels) ASSERT_NEAR(z, 2.0, 1.0 / camera.depth_units_per_m);
  const auto read = ReadCameras(folder.Write("cameras.json", CamerasToJson({camera})));
  EXPECT_TRUE(read.at(0).depth_along_ray);
  EXPECT_NE(CamerasToJson({camera}).find("\"version\": 3"), std::string::npos);
}

TEST(LoadDepth, WhatTheSensorMeasuresTooFarIsTakenOff) {
  const TemporaryFolder folder;
  RgbdCamera camera = SomeCamera();
  WritePng(folder / "d.png", RawDepthImage{40, 30, 1, std::vector<std::uint16_t>(1200, 2000)});
  FrameRecord frame;
  frame.depth.path = "d.png";
  camera.depth_units_per_m = 1000;
  EXPECT_EQ(CamerasToJson({camera}).find("depth_offset_m"), std::string::npos);
  camera.depth_offset_m = 0.125;
  EXPECT_FLOAT_EQ(LoadDepth(frame, camera, folder.Path()).At(3, 4), 1.875f);
  camera.depth_offset_m = 2.5;  // nothing is nearer than the camera
  EXPECT_EQ(LoadDepth(frame, camera, folder.Path()).At(3, 4), 0);
  const auto read =
      ReadCameras(folder.Write("cameras.json", CamerasToJson({SomeCamera(), camera})));
  EXPECT_EQ(read.at(0).depth_offset_m, 0);
  EXPECT_EQ(read.at(1).depth_offset_m, 2.5);
  EXPECT_NE(CamerasToJson({SomeCamera(), camera}).find("\"version\": 4"), std::string::npos);
}

TEST(LoadDepth, UnsureDepthIsNotMeasured) {
  const TemporaryFolder folder;
  RgbdCamera camera = SomeCamera();
  camera.min_confidence = 2;
  WritePng(folder / "d.png", RawDepthImage{40, 30, 1, std::vector<std::uint16_t>(1200, 10000)});
  FrameRecord frame;
  frame.depth.path = "d.png";
  const auto load = [&] { return LoadDepth(frame, camera, folder.Path()); };
  NIGHTMAP_EXPECT_ERROR(DataError, load(), "d.png: no picture of its confidence is listed");
  frame.others[kConfidenceChannel].path = "sure.png";
  NIGHTMAP_EXPECT_ERROR(DataError, load(), "sure.png: no such image file");
  for (const int factor : {1, 2, 5}) {
    GrayImage sure{40 / factor, 30 / factor, 1, {}};
    for (int i = 0; i < sure.width * sure.height; ++i) {
      sure.pixels.push_back(static_cast<std::uint8_t>(i % 4));
    }
    WritePng(folder / "sure.png", sure);
    const DepthImage depth = load();
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        ASSERT_EQ(depth.At(x, y), sure.At(x / factor, y / factor) < 2 ? 0.0f : 2.0f)
            << x << " " << y;
      }
    }
  }
  const auto read = ReadCameras(folder.Write("cameras.json", CamerasToJson({camera})));
  EXPECT_EQ(read.at(0).min_confidence, 2);
  WritePng(folder / "sure.png", GrayImage{20, 30, 1, std::vector<std::uint8_t>(600, 2)});
  NIGHTMAP_EXPECT_ERROR(DataError, load(), "sure.png: 20 x 30 pixels, its depth has 40 x 30");
  const std::string png = ReadBytes(folder / "sure.png");
  folder.Write("sure.png", png.substr(0, png.size() - 20));
  NIGHTMAP_EXPECT_ERROR(DataError, load(), "sure.png: truncated png file: copy it again");
}

TEST(LoadColor, SixteenBitsAreScaledByThoseInUse) {
  const TemporaryFolder folder;
  RgbdCamera camera = SomeCamera();
  Image<std::uint16_t> gray{40, 30, 1, std::vector<std::uint16_t>(1200, 0)};
  for (std::size_t i = 0; i < 1024; ++i) gray.pixels[i] = static_cast<std::uint16_t>(i);
  WritePng(folder / "c.png", gray);
  FrameRecord frame;
  frame.color.path = "c.png";
  const auto load = [&](int num_bits) {
    camera.picture_bits = num_bits;
    return LoadColor(frame, camera, folder.Path());
  };
  for (const int num_bits : {10, 12, 16}) {
    const ColorImage color = load(num_bits);
    for (std::size_t i = 0; i < 1024; ++i) {
      const double expected = 255.0 * static_cast<double>(i) / ((1 << num_bits) - 1);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(color.pixels[3 * i + c], expected, 0.5) << num_bits << " bits: " << i;
      }
    }
  }
  NIGHTMAP_EXPECT_ERROR(
      DataError, load(9), "c.png: a value is 512, more than picture_bits = 9 bits hold: raise");
  camera.picture_bits = 10;
  const std::string json = CamerasToJson({camera});
  EXPECT_NE(json.find("\"version\": 4"), std::string::npos);
  EXPECT_EQ(ReadCameras(folder.Write("cameras.json", json)).at(0).picture_bits, 10);
  WritePng(folder / "c.png", GrayImage{40, 30, 1, std::vector<std::uint8_t>(1200, 200)});
  EXPECT_EQ(load(10).At(0, 0), 200);  // a picture of 8 bits
}

// A camera whose pictures have 80 x 60 pixels, seen as 40 x 30.
RgbdCamera ReducedCamera() {
  RgbdCamera camera = SomeCamera();
  camera.color = {.width = 80, .height = 60, .fx = 70, .fy = 70, .cx = 41, .cy = 29};
  ReduceToWorkingSize(1200e-6, &camera);
  return camera;
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
  const TemporaryFolder folder;
  const std::string json = CamerasToJson({SomeCamera(), camera});
  EXPECT_NE(json.find("\"version\": 5"), std::string::npos);
  const auto read = ReadCameras(folder.Write("cameras.json", json));
  EXPECT_EQ(read.at(0).picture_width, 0);
  EXPECT_EQ(read.at(1).Picture(), camera.Picture());
  std::string smaller = json;
  smaller.replace(smaller.find("\"picture_width\": 80") + 17, 2, "39");
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadCameras(folder.Write("smaller.json", smaller)), "picture_width");
}

TEST(ReduceToWorkingSize, ColorIsTheMeanAndDepthASample) {
  const TemporaryFolder folder;
  const RgbdCamera camera = ReducedCamera();
  ColorImage color{80, 60, 3, {}};
  RawDepthImage raw{80, 60, 1, {}};
  for (int i = 0; i < 80 * 60; ++i) {
    const int x = i % 80, y = i / 80;
    const auto value = static_cast<std::uint8_t>(2 * x + 40 * (y % 2));
    color.pixels.insert(color.pixels.end(), {value, 7, 7});
    raw.pixels.push_back(static_cast<std::uint16_t>(x < 40 ? 10000 : 15000));
  }
  WritePng(folder / "c.png", color);
  WritePng(folder / "d.png", raw);
  FrameRecord frame;
  frame.color.path = "c.png";
  frame.depth.path = "d.png";
  const RgbdImages images = LoadRgbd(frame, camera, folder.Path());
  ASSERT_EQ(images.color.width, 40);
  ASSERT_EQ(images.depth.height, 30);
  for (int x = 0; x < 40; ++x) {
    EXPECT_EQ(images.color.At(x, 3, 0), 2 * (2 * x) + 1 + 20) << x;
    EXPECT_EQ(images.depth.At(x, 3), x < 20 ? 2.0f : 3.0f) << x;
  }
  WritePng(folder / "c.png", ColorImage{40, 30, 3, std::vector<std::uint8_t>(3600, 1)});
  NIGHTMAP_EXPECT_ERROR(DataError,
                        LoadColor(frame, camera, folder.Path()),
                        "c.png: 40 x 30 pixels, its camera has 80");
}

TEST(ReduceToWorkingSize, DepthAlongTheRayAndItsConfidenceAreOfTheStoredPicture) {
  const TemporaryFolder folder;
  RgbdCamera camera = ReducedCamera();
  camera.depth_along_ray = true;
  camera.min_confidence = 1;
  RawDepthImage raw{80, 60, 1, {}};
  GrayImage sure{40, 30, 1, std::vector<std::uint8_t>(1200, 1)};
  sure.At(5, 7) = 0;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      const double ray = camera.Picture().BackProject(Eigen::Vector2d(x, y), 2.0).norm();
      raw.pixels.push_back(static_cast<std::uint16_t>(std::lround(ray * camera.depth_units_per_m)));
    }
  }
  WritePng(folder / "d.png", raw);
  WritePng(folder / "sure.png", sure);
  FrameRecord frame;
  frame.depth.path = "d.png";
  frame.others[kConfidenceChannel].path = "sure.png";
  const DepthImage depth = LoadDepth(frame, camera, folder.Path());
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      if (x == 5 && y == 7) {
        EXPECT_EQ(depth.At(x, y), 0);
      } else {
        ASSERT_NEAR(depth.At(x, y), 2.0, 0.02) << x << " " << y;  // half a pixel of the ray
      }
    }
  }
}

TEST(LoadRgbd, AFrameWithoutDepthHasNoDepthPixels) {
  const TemporaryFolder folder;
  WritePng(folder / "c.png", ColorImage{40, 30, 3, std::vector<std::uint8_t>(3600, 1)});
  FrameRecord frame;
  frame.color.path = "c.png";
  const RgbdImages images = LoadRgbd(frame, SomeCamera(), folder.Path());
  EXPECT_EQ(images.color.pixels.size(), 3600u);
  EXPECT_EQ(images.depth.width, 0);
  EXPECT_TRUE(images.depth.pixels.empty());
  frame.depth.path = "lost.png";
  NIGHTMAP_EXPECT_ERROR(DataError, LoadRgbd(frame, SomeCamera(), folder.Path()), "lost.png");
}

TEST(LoadRgbd, TheCamerasMaskIsTakenOut) {
  const TemporaryFolder folder;
  ColorImage color{40, 30, 3, std::vector<std::uint8_t>(3600, 90)};
  for (int x = 0; x < 40; ++x) color.At(x, 29, 1) = static_cast<std::uint8_t>(250 * (x % 2));
  WritePng(folder / "c.png", color);
  WritePng(folder / "d.png", RawDepthImage{40, 30, 1, std::vector<std::uint16_t>(1200, 10000)});
  FrameRecord frame;
  frame.color.path = "c.png";
  frame.depth.path = "d.png";
  const RgbdCamera camera = MaskedCamera();
  const RgbdImages images = LoadRgbd(frame, camera, folder.Path());
  EXPECT_EQ(images.moving.pixels, camera.mask->pixels);
  for (int x = 0; x < 40; ++x) EXPECT_EQ(images.color.At(x, 29, 1), 90) << x;
  for (std::size_t i = 0; i < images.depth.pixels.size(); ++i) {
    ASSERT_EQ(images.depth.pixels[i] == 0, camera.mask->pixels[i] != 0) << i;
  }
}

TEST(LoadFrame, ImagesOfAnotherSizeAreRefused) {
  const TemporaryFolder folder;
  WritePng(folder / "d.png", RawDepthImage{4, 4, 1, std::vector<std::uint16_t>(16, 1000)});
  WritePng(folder / "c.png", ColorImage{4, 4, 3, std::vector<std::uint8_t>(48, 1)});
  FrameRecord frame;
  frame.color.path = "c.png";
  NIGHTMAP_EXPECT_ERROR(DataError, LoadColor(frame, SomeCamera(), folder.Path()), "c.png: 4 x 4");
  NIGHTMAP_EXPECT_ERROR(DataError, LoadDepth(frame, SomeCamera(), folder.Path()), "no depth");
  frame.depth.path = "d.png";
  NIGHTMAP_EXPECT_ERROR(DataError, LoadDepth(frame, SomeCamera(), folder.Path()), "d.png: 4 x 4");
}

TEST(LoadFrame, AnotherSizeIsRefusedBeforeAPixelIsDecoded) {
  const TemporaryFolder folder;  // headers without the pixels they announce
  folder.Write("c.ppm", "P6\n18000 18000\n255\nabc");
  folder.Write("d.pgm", "P5\n30000 30000\n65535\nab");
  FrameRecord frame;
  frame.color.path = "c.ppm";
  frame.depth.path = "d.pgm";
  NIGHTMAP_EXPECT_ERROR(DataError,
                        LoadColor(frame, SomeCamera(), folder.Path()),
                        "c.ppm: 18000 x 18000 pixels, its camera has 40 x 30");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        LoadDepth(frame, SomeCamera(), folder.Path()),
                        "d.pgm: 30000 x 30000 pixels, its camera has 40 x 30");
  folder.Write("c.ppm", "P6\n30000 30000\n255\nabc");  // more than any picture may have
  NIGHTMAP_EXPECT_ERROR(DataError,
                        LoadColor(frame, SomeCamera(), folder.Path()),
                        "c.ppm: header says 30000 x 30000 pixels of 3 channels");
}

TEST(LoadFrame, ErrorsNameFilesAsTheListsDo) {
  const TemporaryFolder folder;
  FrameRecord frame;
  frame.color.path = folder.Write("c.png", "").filename();
  frame.depth.path = folder.Write("d.png", "hello").filename();
  for (const bool is_color : {true, false}) {
    try {
      is_color ? (void)LoadColor(frame, SomeCamera(), folder.Path())
               : (void)LoadDepth(frame, SomeCamera(), folder.Path());
      ADD_FAILURE() << "was read";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(is_color ? "c.png: " : "d.png: "));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr(folder.Path().string())));
    }
  }
}

TEST(RegisterDepth, EqualCamerasInOnePlaceChangeNothing) {
  RgbdCamera camera = UnregisteredCamera();
  camera.depth = camera.color = SomeCamera().color;  // distortion included
  DepthImage depth = Plane(camera.depth, 0);
  Random random(1);
  for (float& pixel : depth.pixels) pixel = static_cast<float>(random.Uniform(0.5, 4));
  const DepthImage registered = RegisterDepth(depth, camera);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      // Rounding may put a border pixel a hair outside; everything else stays.
      if (x == 0 || y == 0 || x == depth.width - 1 || y == depth.height - 1) continue;
      ASSERT_FLOAT_EQ(registered.At(x, y), depth.At(x, y)) << x << " " << y;
    }
  }
}

TEST(RegisterDepth, PlaneStaysAPlaneWithoutPinholesInAFinerColorImage) {
  RgbdCamera camera = UnregisteredCamera();
  camera.color_from_depth.translation = {0.05, -0.02, 0.1};
  const DepthImage registered = RegisterDepth(Plane(camera.depth, 1.5f), camera);
  for (int y = 10; y < 50; ++y) {
    for (int x = 15; x < 65; ++x) {
      ASSERT_NEAR(registered.At(x, y), 1.6f, 1e-5) << x << " " << y;
    }
  }
}

TEST(RegisterDepth, PointsMoveByTheParallax) {
  RgbdCamera camera = UnregisteredCamera();
  camera.color = camera.depth;
  camera.color_from_depth.translation = {0.2, 0, 0};
  DepthImage depth = Plane(camera.depth, 0);
  depth.At(10, 12) = 1.0f;
  const DepthImage registered = RegisterDepth(depth, camera);
  EXPECT_FLOAT_EQ(registered.At(17, 12), 1.0f);  // 35 px * 0.2 m / 1 m = 7 px
  EXPECT_EQ(std::ranges::count(registered.pixels, 0.0f),
            static_cast<std::ptrdiff_t>(registered.pixels.size()) - 1);
}

TEST(RegisterDepth, TheNearestOfSeveralWins) {
  RgbdCamera camera = UnregisteredCamera();
  camera.color = camera.depth;
  camera.color_from_depth.translation = {0.2, 0, 0};
  for (const bool near_first : {true, false}) {
    DepthImage depth = Plane(camera.depth, 0);
    // Parallax 7 px at 1 m and 3.5 px at 2 m: 10 + 7 = 13.5 + 3.5 px, rounded to the same pixel.
    depth.At(10, near_first ? 12 : 13) = 1.0f;
    depth.At(13, near_first ? 12 : 13) = 2.0f;
    depth.At(14, near_first ? 12 : 13) = 2.0f;
    const DepthImage registered = RegisterDepth(depth, camera);
    EXPECT_FLOAT_EQ(registered.At(17, near_first ? 12 : 13), 1.0f);
  }
}

TEST(RealFrame, LoadsAtFullSize) {
  NIGHTMAP_REQUIRE_DATA("tum_fr1_xyz_15hz");
  RgbdCamera camera = SomeCamera();
  camera.color.width = 640;
  camera.color.height = 480;
  FrameRecord frame;
  frame.color.path = "rgb/1305031102.175304.jpg";
  frame.depth.path = "depth/1305031102.160407.png";
  const auto root = TestDataPath("tum_fr1_xyz_15hz");
  EXPECT_EQ(LoadColor(frame, camera, root).pixels.size(), 640u * 480u * 3u);
  const DepthImage depth = LoadDepth(frame, camera, root);
  const auto num_measured =
      std::ranges::count_if(depth.pixels, [](float depth_m) { return depth_m > 0; });
  EXPECT_GT(num_measured, 640 * 480 / 2);
}

}  // namespace frames_io_test
}  // namespace nightmap
