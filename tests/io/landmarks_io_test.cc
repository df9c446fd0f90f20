// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmarks_io.h"

#include <array>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/landmarks_file.h"
#include "tests/test_data.h"

namespace nightmap::landmarks_io_test {

LandmarkMap MakeMap() {
  LandmarkMap map;
  map.kind = DescriptorKind::kOrb;
  map.positions_in_map = {{1, 2, 3}, {-0.1, 1e-9, 4}};
  map.position_sigmas_m = {0.01F, 0.5F};
  map.descriptor_landmarks = {0, 0, 1};
  for (int i = 0; i < 3 * 32; ++i) map.descriptors.push_back(static_cast<std::uint8_t>(i));
  map.num_word_levels = 2;
  map.words = {1, 5, 2, 6, 3, 7};
  const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())),
                      {0.1, 0.2, 0.3}};
  map.keyframes = {{0, 1000000001, {}}, {4, 1400000001, turned}};
  map.landmark_keyframes = {{0, 1}, {1}};
  map.landmark_features = {{7, 0}, {3}};
  return map;
}

class LandmarksIoTest : public testing::Test {
 protected:
  template <typename Damage>
  void ExpectRefused(const std::string& field, const Damage& damage) const {
    LandmarkMap map = MakeMap();
    damage(map);
    WriteLandmarks(path_, map, "");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadLandmarks(path_), field, "landmarks.h5");
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "landmarks.h5";
  LandmarkMap map_ = MakeMap();
};

TEST_F(LandmarksIoTest, ReadsWhatItWrote) {
  WriteLandmarks(path_, map_, "a = 1\n");
  const LandmarkMap read = ReadLandmarks(path_);
  EXPECT_EQ(read.kind, map_.kind);
  EXPECT_EQ(read.positions_in_map, map_.positions_in_map);
  EXPECT_EQ(read.position_sigmas_m, map_.position_sigmas_m);
  EXPECT_EQ(read.descriptors, map_.descriptors);
  EXPECT_EQ(read.words, map_.words);
  EXPECT_EQ(read.landmark_keyframes, map_.landmark_keyframes);
  EXPECT_EQ(read.landmark_features, map_.landmark_features);
  ASSERT_EQ(read.keyframes.size(), 2U);
  EXPECT_EQ(read.keyframes[1].time_ns, 1400000001);
  EXPECT_EQ(read.keyframes[1].map_from_camera.Matrix(), map_.keyframes[1].map_from_camera.Matrix());
  WriteLandmarks(folder_ / "again.h5", read, "a = 1\n");
  EXPECT_EQ(ReadBytes(path_), ReadBytes(folder_ / "again.h5"));
}

TEST_F(LandmarksIoTest, GivesBothDirectionsOfVisibility) {
  EXPECT_EQ(map_.KeyframeLandmarks(), (std::vector<std::vector<int>>{{0}, {0, 1}}));
  EXPECT_EQ(map_.DescriptorOffsets(), (std::vector<int>{0, 2, 3}));
  EXPECT_EQ(map_.Word(1, 2), 6);
}

TEST_F(LandmarksIoTest, ReadsAnEmptyMap) {
  map_ = LandmarkMap{};
  WriteLandmarks(path_, map_, "");
  EXPECT_EQ(ReadLandmarks(path_).NumLandmarks(), 0);
}

TEST_F(LandmarksIoTest, RefusesEarlierVersionsByWhatTheyLack) {
  Hdf5Writer(path_, "nightmap.landmarks", 1, "", "").Close();
  NIGHTMAP_EXPECT_ERROR(DataError, ReadLandmarks(path_), "landmarks.h5");
}

TEST_F(LandmarksIoTest, RefusesNumbersThatAreNone) {
  ExpectRefused("landmarks/position_in_map_m", [](auto& map) {
    map.positions_in_map[1].y() = std::numeric_limits<double>::quiet_NaN();
  });
  ExpectRefused("keyframes/map_from_camera",
                [](auto& map) { map.keyframes[0].map_from_camera.rotation.coeffs() *= 2.0; });
}

TEST_F(LandmarksIoTest, RefusesIndicesOutOfRange) {
  ExpectRefused("regions/keyframe_idx' has index 2",
                [](auto& map) { map.landmark_keyframes[1] = {2}; });
  ExpectRefused("observations/feature_idx", [](auto& map) { map.landmark_features[0][1] = -1; });
  ExpectRefused("descriptors/landmark_idx", [](auto& map) { map.descriptor_landmarks[2] = 2; });
  ExpectRefused("descriptors/words", [](auto& map) { map.words[3] = -1; });
  ExpectRefused("num_word_levels' is too many levels", [](auto& map) {
    map.num_word_levels = 65;
    map.words.assign(3 * 65, 1);
  });
}

TEST_F(LandmarksIoTest, RefusesLandmarksWithoutDescriptorOrKeyframe) {
  ExpectRefused("descriptors/landmark_idx", [](auto& map) {
    map.descriptor_landmarks = {0, 0, 0};
  });
  const std::string unseen = "' decreases, or has a landmark that no keyframe sees";
  ExpectRefused("observations/offsets" + unseen, [](auto& map) {
    map.landmark_keyframes[1].clear();
    map.landmark_features[1].clear();
  });
}

TEST_F(LandmarksIoTest, RefusesUnsortedVisibilityAndOtherSizes) {
  ExpectRefused("observations/keyframe_idx", [](auto& map) { map.landmark_keyframes[0] = {1, 0}; });
  ExpectRefused("observations/offsets", [](auto& map) {
    map.landmark_keyframes.pop_back();
    map.landmark_features.pop_back();
  });
  ExpectRefused("observations/feature_idx", [](auto& map) { map.landmark_features[0].pop_back(); });
  ExpectRefused("landmarks/position_sigma_m", [](auto& map) { map.position_sigmas_m.pop_back(); });
}

// The map's two landmarks, each in a region of its own, with nothing in between.
class LandmarkRegionsTest : public LandmarksIoTest {
 protected:
  LandmarkRegionsTest() {
    boxes_[0].max_m.x() = boxes_[1].min_m.x() = 0;
    boxes_[1].max_m.x() = boxes_[2].min_m.x() = 0.5;
    regions_[0] = Part(1);
    regions_[2] = Part(0);
    regions_[1] = Part(2);
  }
  static LandmarkMap Part(int landmark) {
    LandmarkMap part = MakeMap();
    if (landmark == 2) {
      part.positions_in_map.clear();
      part.position_sigmas_m.clear();
      part.landmark_keyframes.clear();
      part.landmark_features.clear();
    } else {
      const auto i = static_cast<std::size_t>(landmark);
      part.positions_in_map = {part.positions_in_map[i]};
      part.position_sigmas_m = {part.position_sigmas_m[i]};
      part.landmark_keyframes = {part.landmark_keyframes[i]};
      part.landmark_features = {part.landmark_features[i]};
    }
    const std::size_t begin = landmark == 0 ? 0 : landmark == 1 ? 2 : 3;
    const std::size_t count = landmark == 0 ? 2 : landmark == 1 ? 1 : 0;
    part.descriptor_landmarks.assign(count, 0);
    const auto descriptors = part.descriptors.begin() + static_cast<std::ptrdiff_t>(begin * 32);
    part.descriptors = {descriptors, descriptors + static_cast<std::ptrdiff_t>(count * 32)};
    const auto words = part.words.begin() + static_cast<std::ptrdiff_t>(begin * 2);
    part.words = std::vector<int>(words, words + static_cast<std::ptrdiff_t>(count * 2));
    return part;
  }
  void Write() const {
    LandmarksWriter writer(path_, map_, "");
    for (std::size_t i = 0; i < 3; ++i) writer.Write(boxes_[i], regions_[i]);
    writer.Close();
  }

  std::array<Rectangle, 3> boxes_;
  std::array<LandmarkMap, 3> regions_;
};

TEST_F(LandmarkRegionsTest, EachIsReadAlone) {
  Write();
  LandmarksReader reader(path_);
  EXPECT_EQ(reader.Head().keyframes.size(), 2U);
  EXPECT_EQ(reader.Head().NumLandmarks(), 0);
  ASSERT_EQ(reader.Regions().size(), 3U);
  EXPECT_EQ(reader.Regions()[0].keyframes, (std::vector<int>{1}));
  EXPECT_EQ(reader.Regions()[1].keyframes, std::vector<int>{});
  EXPECT_EQ(reader.Regions()[2].keyframes, (std::vector<int>{0, 1}));
  EXPECT_EQ(reader.Regions()[2].box.min_m.x(), 0.5);
  EXPECT_TRUE(reader.Regions()[2].box.Contains({1e9, -1e9}));
  for (const std::size_t i : {2, 0, 1}) {
    const LandmarkMap region = reader.Read(i);
    EXPECT_EQ(region.NumLandmarks(), reader.Regions()[i].num_landmarks);
    EXPECT_EQ(region.positions_in_map, regions_[i].positions_in_map);
    EXPECT_EQ(region.descriptors, regions_[i].descriptors);
    EXPECT_EQ(region.words, regions_[i].words);
    EXPECT_EQ(region.landmark_features, regions_[i].landmark_features);
  }
}

TEST_F(LandmarkRegionsTest, TogetherAreTheMap) {
  Write();
  const LandmarkMap read = ReadLandmarks(path_);
  EXPECT_EQ(read.keyframes.size(), 2U);
  EXPECT_EQ(read.positions_in_map,
            (std::vector{map_.positions_in_map[1], map_.positions_in_map[0]}));
  EXPECT_EQ(read.descriptor_landmarks, (std::vector<int>{0, 1, 1}));
  EXPECT_EQ(read.words, (std::vector<int>{3, 7, 1, 5, 2, 6}));
  EXPECT_EQ(read.landmark_keyframes, (std::vector<std::vector<int>>{{1}, {0, 1}}));
  EXPECT_EQ(read.landmark_features, (std::vector<std::vector<int>>{{3}, {7, 0}}));
}

TEST_F(LandmarkRegionsTest, DamageIsNamedWithTheRegionAndHurtsNoOther) {
  regions_[2].landmark_features[0].pop_back();
  Write();
  LandmarksReader reader(path_);
  EXPECT_EQ(reader.Read(0).NumLandmarks(), 1);
  NIGHTMAP_EXPECT_ERROR(
      DataError, reader.Read(2), "landmarks.h5", "region_2/observations/feature_idx");
}

TEST_F(LandmarkRegionsTest, LandmarksElsewhereAreRefused) {
  boxes_[2].min_m.x() = 1.5;
  Write();
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadLandmarks(path_),
                        "region_2/landmarks/position_in_map_m' lies outside of the region");
}

TEST_F(LandmarkRegionsTest, BoxesWithoutInsideAreRefused) {
  boxes_[1].max_m.x() = 0;
  Write();
  NIGHTMAP_EXPECT_ERROR(DataError, LandmarksReader(path_), "regions/max_m");
}

}  // namespace nightmap::landmarks_io_test
