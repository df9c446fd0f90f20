// SPDX-License-Identifier: Apache-2.0
// Every reader of an artifact that is no HDF5 against damaged files; hdf5_formats_test.cc has
// those.
#include "pipeline/dense/octree_io.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/dense/tile_results.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/g2o_io.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/queries_io.h"
#include "pipeline/io/things_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/plan/path_io.h"
#include "tests/io/artifact_damage.h"

namespace nightmap::corrupt_artifacts_test {

using Path = std::filesystem::path;

Rigid3 SomePose(int i) {
  const Eigen::AngleAxisd turn(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized());
  return {Eigen::Quaterniond(turn), {0.5 * i, -1, 1.0 / 3}};
}

FrameRecord SomeFrame(int i) {
  return {i, 1'000'000'000LL * i, 0, 0, {"color/1.png", "12"}, {"depth/1.png", "ef"}, {}};
}

std::string SomeTile() {
  Tile tile;
  tile.region = {{{-1, -2}, {3, 4}}, 0.5, 4};
  for (int i = 0; i < 3; ++i) tile.keyframes.push_back({i, SomeFrame(2 * i), SomePose(i)});
  return TileToJson(tile);
}

std::string SomeGraph() {
  PoseGraph graph;
  for (int i = 0; i < 3; ++i) graph.vertices.push_back({i, SomePose(i)});
  graph.edges.push_back({0, 1, SomePose(1), Matrix6d::Identity(), false});
  return PoseGraphToG2o(graph);
}

std::string SomeTrajectory() {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 4; ++i) poses.push_back({1'000'000'000LL * i, SomePose(i)});
  return TrajectoryToTum(poses, "map_from_camera");
}

std::string SomeQueries() {
  QueryResult located;
  located.color_path = "a.png";
  located.map_from_camera = SomePose(1);
  located.verdict = QueryVerdict::kLocated;
  QueryResult lost;
  lost.color_path = "b.png";
  lost.verdict = QueryVerdict::kNotInMap;
  lost.reason = "too_few_matches";
  return QueriesToCsv({located, lost});
}

OccupancyGrid SomeGrid() { return {4, 3, 0.1, {1, 2}, std::vector<std::uint8_t>(12, kFreeCell)}; }

std::string SomeCameras() {
  RgbdCamera camera;
  camera.camera_id = "front";
  camera.color = camera.depth = {640, 480, 500, 500, 320, 240};
  camera.depth_registered = false;
  return CamerasToJson({camera, camera});
}

std::string SomeThings() {
  Thing thing{"sofa_1", "sofa", {0.5, {1, 2}}, 0, {0.9, 2, 0.8}, 3, 0.75};
  thing.best_view = {1'000'000'000, "a.png", {1, 2, 30, 40}};
  Thing other = thing;
  other.name = "sofa_2";
  return ThingsToJson({thing, other});
}

class CorruptArtifactsTest : public testing::Test {
 protected:
  template <typename Read>
  void ExpectText(const std::string& name, const std::string& text, const Read& read) const {
    SCOPED_TRACE(name);
    ExpectDamageIsSurvived(folder_, folder_.Write(name, text), read);
  }
  TemporaryFolder folder_;
};

TEST_F(CorruptArtifactsTest, Clouds) {
  WritePly(folder_ / "a.ply", std::vector<CloudPoint>(5));
  ExpectDamageIsSurvived(folder_, folder_ / "a.ply", ReadPly);
}

TEST_F(CorruptArtifactsTest, Octrees) {
  OccupancyTree tree{0.1, {}};
  for (int i = 0; i < 20; ++i) tree.leaves.push_back({{0.05 + 0.3 * i, 0.05, 0.05}, 0.1, 1});
  WriteOctree(folder_ / "a.ot", tree);
  ExpectDamageIsSurvived(folder_, folder_ / "a.ot", ReadOctree);
}

TEST_F(CorruptArtifactsTest, Grids) {
  ReadChannels(folder_.Write("a.ppm", "P3 1 1 255 1 2 3"));  // loads media.h, which takes memory
  folder_.Write("map.pgm", GridToPgm(SomeGrid()));
  ExpectText(
      "map.yaml", GridToYaml(SomeGrid(), "map.pgm"), [](const Path& path) { ReadGrid(path); });
  folder_.Write("damaged.yaml", GridToYaml(SomeGrid(), "damaged.pgm"));
  ExpectText("a.pgm", GridToPgm(SomeGrid()), [](const Path& path) {
    if (path.stem() == "damaged") ReadGrid(Path(path).replace_extension(".yaml"));
  });
}

TEST_F(CorruptArtifactsTest, MapsOfOthers) {
  folder_.Write("map.pgm", GridToPgm(SomeGrid()));
  ExpectText(
      "other.yaml",
      "%YAML 1.1\n---\n\"image\": map.pgm\nnegate: no\norigin: &o\n- -1.5\n- 2.0\n- 0\n"
      "resolution: !!float 0.05\nfree_thresh: 0.2\noccupied_thresh: 0.65\nmore: [*o, {a: 1}]\n",
      [](const Path& path) { ReadGrid(path); });
  folder_.Write("damaged.yaml", GridToYaml(SomeGrid(), "damaged.pgm"));
  for (const std::string pgm :
       {"P2\n# a\n4 2\n255\n0 205 254 255\n0 0 0 0\n", "P5\n2 2\n65535\nabcdefgh"}) {
    ExpectText("a.pgm", pgm, [](const Path& path) {
      if (path.stem() == "damaged") ReadGrid(Path(path).replace_extension(".yaml"));
    });
  }
}

TEST_F(CorruptArtifactsTest, ListsAndTables) {
  const std::vector<FloorFiles> floors = {{0, 0, "a.yaml", "a.png", "a.h5"},
                                          {1, 2.5, "b.yaml", "b.png", "b.h5"}};
  const std::string frames = FramesToCsv({SomeFrame(0), SomeFrame(1), SomeFrame(2)});
  ExpectText("floors.json", FloorsToJson(floors), ReadFloors);
  ExpectText("tile_0_0.json", SomeTile(), ReadTile);
  ExpectText("frames.csv", frames, [](const Path& path) { ReadFrames(path); });
  ExpectText("cameras.json", SomeCameras(), [](const Path& path) { ReadCameras(path); });
  ExpectText("things.json", SomeThings(), ReadThings);
  ExpectText("queries.csv", SomeQueries(), ReadQueries);
  ExpectText("a.tum", SomeTrajectory(), [](const Path& path) { ReadTum(path); });
  ExpectText("a.g2o", SomeGraph(), ReadG2o);
}

TEST_F(CorruptArtifactsTest, TileReports) {
  const auto tile = folder_.Write("tile_0_0.json", SomeTile());
  const std::string report =
      "{\"config\": \"keyframe_stride = 1\\n\", \"num_points\": 12, "
      "\"skipped\": [\"a.png: truncated\", \"b\"]}\n";
  ExpectText("report_0_0.json", report, [&](const Path& path) {
    ReadTileResults({tile}, {path});
    SumOfReports({path}, "num_points");
  });
}

TEST_F(CorruptArtifactsTest, Paths) {
  const std::string header = "x_m,y_m,heading_rad,distance_m,leg_idx\n";
  const std::string csv = header + "0,0,0,0,0\n1,0,0,1,0\n2,0,0,2,1\n";
  const std::string json =
      "{\"format\": \"nightmap_path\", \"version\": 3, \"num_points\": 3, \"floor\": 0,\n"
      "\"num_legs\": 2, \"length_m\": 2, \"config\": \"robot_radius_m = 0.2\\nfootprint_m = [0.3, "
      "0.2, -0.3, 0.2, 0, -0.2]\\n"
      "unknown = \\\"forbidden\\\"\\n\"}";
  const auto whole_json = folder_.Write("whole.json", json);
  ExpectText("a.csv", csv, [&](const Path& path) { ReadPlannedPath(path, whole_json); });
  const auto whole_csv = folder_.Write("whole.csv", csv);
  ExpectText("a.json", json, [&](const Path& path) { ReadPlannedPath(whole_csv, path); });
}

// Whatever recursion a parser or its values have must not end the stack.
TEST_F(CorruptArtifactsTest, DeeplyNestedJson) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  const auto tile = folder_.Write("tile_0_0.json", SomeTile());
  const auto csv = folder_.Write("a.csv", "x_m,y_m,heading_rad,distance_m,leg_idx\n0,0,0,0,0\n");
  for (const std::string field :
       {"format", "version", "cameras", "floors", "keyframes", "things", "config", "skipped"}) {
    const std::string config = field == "config" ? "" : R"("config": "keyframe_stride = 1", )";
    const std::string text =
        R"({"format": "nightmap floors", )" + config + "\"" + field + "\": " + deep + "}";
    const auto path = folder_.Write("deep.json", text);
    EXPECT_THROW(ReadFloors(path), DataError);
    EXPECT_THROW(ReadTile(path), DataError);
    EXPECT_THROW(ReadThings(path), DataError);
    EXPECT_THROW(ReadCameras(path), DataError);
    EXPECT_THROW(ReadPlannedPath(csv, path), DataError);
    EXPECT_THROW(SumOfReports({path}, field), DataError);
    if (field == "skipped" || field == "config") {
      EXPECT_THROW(ReadTileResults({tile}, {path}), DataError);
    }
  }
}

}  // namespace nightmap::corrupt_artifacts_test
