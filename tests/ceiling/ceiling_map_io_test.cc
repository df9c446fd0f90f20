// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_map_io.h"

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/io/hdf5_damage.h"
#include "tests/test_data.h"

namespace nightmap::ceiling_map_io_test {

CeilingMap MakeMap() {
  CeilingMap map;
  CeilingFrame frame;
  frame.time_ns = 17;
  frame.map_from_robot_then = {0.5, {1, 2}};
  frame.covariance = 0.25 * Eigen::Matrix3d::Identity();
  frame.nis = 3.5;
  frame.num_residuals = 4;
  frame.has_slipped = true;
  map.frames = {frame};
  map.anchors = {{{0.1, {3, 4}}, Eigen::Matrix3d::Identity()}};
  CeilingLandmark landmark;
  landmark.track_id = 9;
  landmark.position_m = {1, 2, 2.5};
  landmark.covariance_m2 = Eigen::Vector3d(0.04, 0.01, 0.01).asDiagonal();
  landmark.num_sightings = 6;
  map.landmarks = {landmark};
  map.anchors.push_back({{-0.2, {5, 4}}, 2 * Eigen::Matrix3d::Identity()});
  map.loops = {{1, 0, 12}};
  map.met_again = {{21, 9}};
  map.mounting << 0.01, 0.02, 0.03, 0.04, 0.05;
  return map;
}

TEST(CeilingMapIo, WritesWhatItWasGiven) {
  const TemporaryFolder folder;
  const auto path = folder / "ceiling_map.h5";
  WriteCeilingMap(path, MakeMap(), "a = 1");
  const Hdf5Reader file(path, "nightmap ceiling map", 2);
  EXPECT_EQ(file.ReadList<std::int64_t>("frame_time_ns"), std::vector<std::int64_t>{17});
  EXPECT_EQ(file.Read<double>("frame_pose", 3).values, (std::vector<double>{1, 2, 0.5}));
  EXPECT_EQ(file.Read<double>("frame_covariance", 9).values[4], 0.25);
  EXPECT_EQ(file.ReadList<std::uint8_t>("frame_flags"), std::vector<std::uint8_t>{2});
  EXPECT_EQ(file.Read<double>("landmark_position_m", 3).values, (std::vector<double>{1, 2, 2.5}));
  EXPECT_EQ(file.Read<std::int32_t>("loop_anchors", 2).values, (std::vector<std::int32_t>{1, 0}));
  EXPECT_EQ(file.ReadText("config"), "a = 1");
}

TEST(CeilingMapIo, ReadsBackWhatItWrote) {
  const TemporaryFolder folder;
  const auto path = folder / "ceiling_map.h5", again = folder / "again.h5";
  WriteCeilingMap(path, MakeMap(), "a = 1");
  const CeilingMap map = ReadCeilingMap(path);
  EXPECT_TRUE(map.frames.at(0).has_slipped);
  EXPECT_EQ(map.landmarks.at(0).position_m, Eigen::Vector3d(1, 2, 2.5));
  EXPECT_EQ(map.met_again.at(0).landmark_track_id, 9);
  WriteCeilingMap(again, map, "a = 1");
  EXPECT_EQ(ReadBytes(path), ReadBytes(again));
}

TEST(CeilingMapIo, TheMountingIsAddedInTheFramesItIsOf) {
  const Rigid3 as_configured{Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ())),
                             {0.1, 0, 0.3}};
  const Rigid3 mounted = MountedAs(as_configured, MakeMap());
  EXPECT_NEAR((mounted.translation - Eigen::Vector3d(0.14, 0.05, 0.3)).norm(), 0, 1e-12);
  const Eigen::AngleAxisd turn(as_configured.rotation.conjugate() * mounted.rotation);
  EXPECT_NEAR((turn.angle() * turn.axis() - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 0, 1e-12);
  EXPECT_EQ(MountedAs(as_configured, {}).rotation.coeffs(), as_configured.rotation.coeffs());
}

TEST(CeilingMapIo, RefusesWhatDoesNotFit) {
  const TemporaryFolder folder;
  const auto refused = [&](const CeilingMap& map, const char* field) {
    const auto path = folder / "bad.h5";
    WriteCeilingMap(path, map, "");
    EXPECT_THAT([&] { ReadCeilingMap(path); },
                testing::ThrowsMessage<DataError>(
                    testing::AllOf(testing::HasSubstr("bad.h5"), testing::HasSubstr(field))));
  };
  CeilingMap map = MakeMap();
  map.met_again = {{21, 8}};
  refused(map, "met_again_track_id");
  map = MakeMap();
  map.loops[0].now = 2;
  refused(map, "loop_anchors");
  map = MakeMap();
  map.landmarks[0].anchor = -1;
  refused(map, "landmark_anchor");
  map = MakeMap();
  map.landmarks.push_back(map.landmarks[0]);
  refused(map, "landmark_track_id");
  map = MakeMap();
  map.frames.push_back(map.frames[0]);
  refused(map, "frame_time_ns");
}

TEST(CeilingMapIo, RefusesADamagedFile) {
  const TemporaryFolder folder;
  const auto path = folder / "ceiling_map.h5";
  WriteCeilingMap(path, MakeMap(), "");
  ExpectTruncationIsNamed(
      folder, path, [](const std::filesystem::path& at) { ReadCeilingMap(at); });
}

TEST(CeilingMapIo, EqualMapsGiveEqualBytes) {
  const TemporaryFolder folder;
  const auto a = folder / "a.h5", b = folder / "b.h5";
  WriteCeilingMap(a, MakeMap(), "");
  WriteCeilingMap(b, MakeMap(), "");
  EXPECT_EQ(ReadBytes(a), ReadBytes(b));
}

TEST(CeilingMapIo, AnEmptyMapIsAFile) {
  const TemporaryFolder folder;
  WriteCeilingMap(folder / "empty.h5", {}, "");
  const Hdf5Reader file(folder / "empty.h5", "nightmap ceiling map", 2);
  EXPECT_TRUE(file.ReadList<std::int64_t>("landmark_track_id").empty());
  EXPECT_THAT(LandmarksToPly({}), testing::HasSubstr("element vertex 0"));
}

TEST(CeilingMapIo, PlyHasTheLargestDeviation) {
  EXPECT_THAT(LandmarksToPly(MakeMap().landmarks),
              testing::HasSubstr("1.0000 2.0000 2.5000 0 96 255 0.2000\n"));
}

}  // namespace nightmap::ceiling_map_io_test
