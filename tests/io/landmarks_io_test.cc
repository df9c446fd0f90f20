// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmarks_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
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
  ExpectRefused("observations/keyframe_idx' has index 2",
                [](auto& map) { map.landmark_keyframes[1] = {2}; });
  ExpectRefused("observations/feature_idx", [](auto& map) { map.landmark_features[0][1] = -1; });
  ExpectRefused("descriptors/landmark_idx", [](auto& map) { map.descriptor_landmarks[2] = 2; });
  ExpectRefused("descriptors/words", [](auto& map) { map.words[3] = -1; });
  ExpectRefused("descriptors/words' has too many levels", [](auto& map) {
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

}  // namespace nightmap::landmarks_io_test
