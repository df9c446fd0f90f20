// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/features_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::features_io_test {

FrameFeatures MakeFrame(int frame_idx, int count, int size) {
  FrameFeatures frame;
  frame.frame_idx = frame_idx;
  for (int i = 0; i < count; ++i) {
    const auto value = static_cast<float>(10 * frame_idx + i);
    frame.keypoints_px.emplace_back(value, 2 * value);
    frame.raw_keypoints_px.emplace_back(value + 0.5F, 2 * value + 0.5F);
    frame.scales_px.push_back(value + 1);
    frame.depths_m.push_back(i % 2 == 0 ? 0.0F : value);
    for (int k = 0; k < size; ++k) frame.descriptors.push_back(static_cast<std::uint8_t>(i + k));
  }
  return frame;
}

// A frame that continues features 2 and 0 of `reference`.
FrameFeatures MakeTracked(int frame_idx, int reference) {
  FrameFeatures frame = MakeFrame(frame_idx, 2, 0);
  frame.reference_frame_idx = reference;
  frame.reference_features = {2, 0};
  return frame;
}

FeaturesShard MakeShard(DescriptorKind kind, int first_frame_idx) {
  FeaturesShard shard;
  shard.kind = kind;
  shard.descriptor_size = DescriptorSize(kind);
  shard.extraction = "detector = \"sift\"\n";
  for (const int count : {3, 0, 2}) {
    const int frame_idx = first_frame_idx + static_cast<int>(shard.frames.size());
    shard.frames.push_back(MakeFrame(frame_idx, count, shard.descriptor_size));
  }
  shard.frames.insert(shard.frames.begin() + 1, MakeTracked(first_frame_idx + 1, first_frame_idx));
  for (std::size_t i = 0; i < 4; ++i) {
    shard.frames[i].frame_idx = first_frame_idx + static_cast<int>(i);
  }
  return shard;
}

void ExpectEqual(const FrameFeatures& a, const FrameFeatures& b) {
  EXPECT_EQ(a.frame_idx, b.frame_idx);
  EXPECT_EQ(a.keypoints_px, b.keypoints_px);
  EXPECT_EQ(a.raw_keypoints_px, b.raw_keypoints_px);
  EXPECT_EQ(a.scales_px, b.scales_px);
  EXPECT_EQ(a.depths_m, b.depths_m);
  EXPECT_EQ(a.descriptors, b.descriptors);
  EXPECT_EQ(a.reference_frame_idx, b.reference_frame_idx);
  EXPECT_EQ(a.reference_features, b.reference_features);
}

class FeaturesIo : public InFolder {};

TEST_F(FeaturesIo, ReadsBackEveryKindAndFramesWithoutFeatures) {
  for (const auto kind :
       {DescriptorKind::kRootSift, DescriptorKind::kOrb, DescriptorKind::kBrisk}) {
    const FeaturesShard shard = MakeShard(kind, 7);
    WriteFeatures(folder_ / "f.h5", shard, "config");
    const FeaturesShard read = ReadFeatures(folder_ / "f.h5");
    EXPECT_EQ(read.kind, kind);
    EXPECT_EQ(read.extraction, shard.extraction);
    ASSERT_EQ(read.frames.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i) ExpectEqual(read.frames[i], shard.frames[i]);
  }
}

TEST_F(FeaturesIo, HeadsAreFramesWithoutFeatures) {
  const FeaturesShard shard = MakeShard(DescriptorKind::kBrisk, 7);
  WriteFeatures(folder_ / "f.h5", shard, "config");
  const auto [heads, num_features] = ReadFeatureHeads(folder_ / "f.h5");
  EXPECT_EQ(heads.kind, shard.kind);
  EXPECT_EQ(heads.extraction, shard.extraction);
  ASSERT_EQ(heads.frames.size(), shard.frames.size());
  for (std::size_t i = 0; i < shard.frames.size(); ++i) {
    EXPECT_EQ(heads.frames[i].frame_idx, shard.frames[i].frame_idx);
    EXPECT_EQ(heads.frames[i].IsDescribed(), shard.frames[i].IsDescribed());
    EXPECT_EQ(heads.frames[i].NumFeatures(), 0);
    EXPECT_EQ(num_features.at(i), shard.frames[i].NumFeatures());
  }
}

TEST_F(FeaturesIo, SizesThatDoNotAddUpAndNanAreRefused) {
  using Frames = std::vector<FrameFeatures>;
  const auto expect = [&](const std::string& field, const std::function<void(Frames&)>& damage) {
    FeaturesShard shard = MakeShard(DescriptorKind::kOrb, 0);
    damage(shard.frames);
    if (field == "descriptor") shard.kind = DescriptorKind::kBrisk;
    WriteFeatures(folder_ / "f.h5", shard, "");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFeatures(folder_ / "f.h5"), "f.h5", "'" + field + "'");
  };
  using Limits = std::numeric_limits<float>;
  expect("scale_px", [](Frames& frames) { frames[0].scales_px.pop_back(); });
  expect("depth_m", [](Frames& frames) { frames[3].depths_m.push_back(1); });
  expect("raw_keypoint_px", [](Frames& frames) { frames[0].raw_keypoints_px.pop_back(); });
  expect("keypoint_px",
         [](Frames& frames) { frames[0].keypoints_px[1].x() = Limits::quiet_NaN(); });
  expect("depth_m", [](Frames& frames) { frames[3].depths_m[1] = Limits::infinity(); });
  expect("depth_m", [](Frames& frames) { frames[3].depths_m[1] = -0.5F; });
  expect("scale_px", [](Frames& frames) { frames[0].scales_px[2] = -1; });
  expect("reference_feature", [](Frames& frames) { frames[1].reference_features[1] = 3; });
  expect("reference_feature", [](Frames& frames) { frames[1].reference_features[0] = -1; });
  for (const int none : {1, 2, 9}) {  // itself, later, not there
    expect("reference_frame_idx", [=](Frames& frames) { frames[1].reference_frame_idx = none; });
  }
  expect("descriptor", [](Frames&) {});  // of 32 bytes said to have 64
}

// Two features of two frames as another program might write them.
void WriteArrays(const std::filesystem::path& path,
                 std::int32_t kind,
                 const std::vector<std::int32_t>& first_feature,
                 const std::string& left_out = "") {
  Hdf5Writer file(path, "nightmap features", 2, "", "");
  if (left_out != "extraction") file.WriteText("extraction", "");
  const auto write = [&]<typename T>(const std::string& name, const Array<T>& array) {
    if (name != left_out) file.Write(name, array);
  };
  write("kind", Array<std::int32_t>{1, 1, {kind}});
  write("frame_idx", Array<std::int32_t>{2, 1, {5, 6}});
  write("reference_frame_idx", Array<std::int32_t>{2, 1, {-1, -1}});
  write("reference_feature", Array<std::int32_t>{0, 1, {}});
  write("first_feature", Array<std::int32_t>{first_feature.size(), 1, first_feature});
  for (const char* name : {"keypoint_px", "raw_keypoint_px"}) {
    write(name, Array<float>{2, 2, {1, 2, 3, 4}});
  }
  for (const char* name : {"scale_px", "depth_m"}) write(name, Array<float>{2, 1, {1, 2}});
  write("descriptor", Array<std::uint8_t>{2, 32, std::vector<std::uint8_t>(64)});
  file.Close();
}

TEST_F(FeaturesIo, MissingArraysAndIndicesOutOfRangeAreNamed) {
  const auto path = folder_ / "f.h5";
  constexpr std::int32_t kOrb = 1;
  WriteArrays(path, kOrb, {0, 2, 2});
  EXPECT_EQ(ReadFeatures(path).frames[0].NumFeatures(), 2);
  for (const std::string field : {"extraction",
                                  "kind",
                                  "frame_idx",
                                  "first_feature",
                                  "reference_frame_idx",
                                  "reference_feature",
                                  "keypoint_px",
                                  "raw_keypoint_px",
                                  "scale_px",
                                  "depth_m",
                                  "descriptor"}) {
    WriteArrays(path, kOrb, {0, 2, 2}, field);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFeatures(path), "f.h5: field '" + field + "' is missing");
  }
  using List = std::vector<std::int32_t>;
  for (const List& first : {List{},
                            List{0, 2},
                            List{0, 1, 2, 2},
                            List{1, 1, 2},
                            List{0, 1, 1},
                            List{0, 1, 3},
                            List{0, 3, 2},
                            List{0, -1, 2}}) {
    WriteArrays(path, kOrb, first);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFeatures(path), "f.h5: field 'first_feature'");
  }
  for (const std::int32_t kind : {-1, 3}) {
    WriteArrays(path, kind, {0, 2, 2});
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFeatures(path), "f.h5: field 'kind'");
  }
}

}  // namespace nightmap::features_io_test
