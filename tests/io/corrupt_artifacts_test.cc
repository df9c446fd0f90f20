// SPDX-License-Identifier: Apache-2.0
// Every reader of an artifact against damaged files.
#include "pipeline/dense/octree_io.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/dense/tile_results.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/g2o_io.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/labels_io.h"
#include "pipeline/io/landmarks_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"
#include "pipeline/io/queries_io.h"
#include "pipeline/io/things_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/plan/path_io.h"
#include "tests/io/artifact_damage.h"

namespace nightmap {
namespace corrupt_artifacts_test {

using Path = std::filesystem::path;

Rigid3 SomePose(int i) {
  const Eigen::AngleAxisd turn(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized());
  return {Eigen::Quaterniond(turn), {0.5 * i, -1, 1.0 / 3}};
}

FrameRecord SomeFrame(int i) {
  return {i, 1'000'000'000LL * i, 0, 0, {"color/1.png", "12"}, {"depth/1.png", "ef"}, {}};
}

void WriteSomePairs(const Path& path) {
  std::vector<FramePair> pairs(3);
  for (int i = 0; i < 3; ++i) {
    FramePair& pair = pairs[static_cast<std::size_t>(i)];
    pair.frame_a = i;
    pair.frame_b = i + 2;
    pair.b_from_a = SomePose(i);
    pair.inliers = {{1, 2}, {3, 4}};
  }
  WritePairs(path, pairs, "size = 1\n");
}

void WriteSomeOdometry(const Path& path) {
  OdometryShard shard;
  for (int i = 0; i < 4; ++i) {
    shard.frames.push_back({i, SomePose(i), TrackingState::kTracked, true});
  }
  shard.edges.push_back({0, 1, SomePose(1), Matrix6d::Identity(), false});
  shard.tracks = {{{0, 5}, {1, 6}}, {{2, 7}}};
  WriteOdometry(path, shard, "size = 1\n");
}

void WriteSomeEdges(const Path& path) {
  const Matrix6d covariance = Matrix6d::Identity();
  WriteEdges(path,
             {"wheels",
              {{EdgeKind::kPrior, 7, 7, SomePose(0), covariance},
               {EdgeKind::kOdometry, 7, 8, SomePose(1), covariance},
               {EdgeKind::kLoop, 9, 7, SomePose(2), covariance}}},
             "size = 1\n");
}

void WriteSomeFeatures(const Path& path) {
  FeaturesShard shard;
  shard.kind = DescriptorKind::kOrb;
  shard.descriptor_size = 32;
  for (int i = 0; i < 3; ++i) {
    FrameFeatures& frame = shard.frames.emplace_back();
    frame.frame_idx = i;
    frame.keypoints_px = frame.raw_keypoints_px = {{1, 2}, {3, 4}};
    frame.scales_px = {5, 6};
    frame.depths_m = {0, 2};
    if (i == 0) {
      frame.descriptors.assign(64, 7);
    } else {
      frame.reference_frame_idx = 0;
      frame.reference_features = {1, 0};
    }
  }
  WriteFeatures(path, shard, "size = 1\n");
}

void WriteSomeLandmarks(const Path& path) {
  LandmarkMap map;
  map.kind = DescriptorKind::kOrb;
  map.positions_in_map = {{0, 1, 2}, {3, 4, 5}};
  map.position_sigmas_m = {0.1F, 0.2F};
  map.descriptors.assign(96, 1);
  map.descriptor_landmarks = {0, 0, 1};
  map.num_word_levels = 2;
  map.words = {1, 3, 1, 3, 2, 2};
  map.keyframes = {{0, 1, SomePose(0)}, {5, 2, SomePose(1)}};
  map.landmark_keyframes = map.landmark_features = {{0, 1}, {1}};
  WriteLandmarks(path, map, "size = 1\n");
}

void WriteSomeLabels(const Path& path) {
  const GrayImage image{8, 6, 1, std::vector<std::uint8_t>(48, 1)};
  WriteLabels(path,
              {{{"background", "person"}, {0, 1}},
               {PackLabels(3, 1'000, {image, image}), PackLabels(4, 2'000, {image, image})}},
              "size = 1\n");
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

std::vector<RgbdCamera> SomeCameras() {
  RgbdCamera camera;
  camera.camera_id = "front";
  camera.color = camera.depth = {640, 480, 500, 500, 320, 240};
  camera.depth_registered = false;
  return {camera, camera};
}

class CorruptArtifactsTest : public testing::Test {
 protected:
  template <typename Write, typename Read>
  void Expect(const std::string& name, const Write& write, const Read& read) const {
    write(folder_ / name);
    ExpectDamageIsSurvived(folder_, folder_ / name, read);
  }
  template <typename Read>
  void ExpectText(const std::string& name, const std::string& text, const Read& read) const {
    ExpectDamageIsSurvived(folder_, folder_.Write(name, text), read);
  }
  TemporaryFolder folder_;
};

TEST_F(CorruptArtifactsTest, Matches) {
  Expect("a.h5", WriteSomePairs, [](const Path& path) { ReadPairs(path); });
}

TEST_F(CorruptArtifactsTest, Odometry) {
  Expect("a.h5", WriteSomeOdometry, [](const Path& path) { ReadOdometry(path); });
}

TEST_F(CorruptArtifactsTest, Edges) {
  Expect("a.h5", WriteSomeEdges, [](const Path& path) { ReadEdges(path); });
}

TEST_F(CorruptArtifactsTest, Features) {
  Expect("a.h5", WriteSomeFeatures, [](const Path& path) { ReadFeatures(path); });
}

TEST_F(CorruptArtifactsTest, Landmarks) {
  Expect("a.h5", WriteSomeLandmarks, [](const Path& path) { ReadLandmarks(path); });
}

TEST_F(CorruptArtifactsTest, Labels) {
  Expect("a.h5", WriteSomeLabels, [](const Path& path) {
    const LabelsReader reader(path);
    for (const PackedLabels& frame : reader.Frames()) reader.Read(frame.time_ns);
  });
}

TEST_F(CorruptArtifactsTest, Clouds) {
  const auto write = [](const Path& path) { WritePly(path, std::vector<CloudPoint>(5)); };
  Expect("a.ply", write, [](const Path& path) { ReadPly(path); });
}

TEST_F(CorruptArtifactsTest, Octrees) {
  const auto write = [](const Path& path) {
    OccupancyTree tree{0.1, {}};
    for (int i = 0; i < 20; ++i) tree.leaves.push_back({{0.05 + 0.3 * i, 0.05, 0.05}, 0.1, 1});
    WriteOctree(path, tree);
  };
  Expect("a.ot", write, [](const Path& path) { ReadOctree(path); });
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

TEST_F(CorruptArtifactsTest, Floors) {
  const std::vector<FloorFiles> floors = {{0, 0, "a.yaml", "a.png", "a.h5"},
                                          {1, 2.5, "b.yaml", "b.png", "b.h5"}};
  ExpectText("a.json", FloorsToJson(floors), [](const Path& path) { ReadFloors(path); });
}

TEST_F(CorruptArtifactsTest, Tiles) {
  ExpectText("tile_0_0.json", SomeTile(), [](const Path& path) { ReadTile(path); });
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

TEST_F(CorruptArtifactsTest, Frames) {
  const std::string text = FramesToCsv({SomeFrame(0), SomeFrame(1), SomeFrame(2)});
  ExpectText("a.csv", text, [](const Path& path) { ReadFrames(path); });
}

TEST_F(CorruptArtifactsTest, Cameras) {
  ExpectText("a.json", CamerasToJson(SomeCameras()), [](const Path& path) { ReadCameras(path); });
}

TEST_F(CorruptArtifactsTest, Things) {
  Thing thing{"sofa_1", "sofa", {0.5, {1, 2}}, 0, {0.9, 2, 0.8}, 3, 0.75};
  thing.best_view = {1'000'000'000, "a.png", {1, 2, 30, 40}};
  Thing other = thing;
  other.name = "sofa_2";
  ExpectText("a.json", ThingsToJson({thing, other}), [](const Path& path) { ReadThings(path); });
}

TEST_F(CorruptArtifactsTest, Queries) {
  ExpectText("a.csv", SomeQueries(), [](const Path& path) { ReadQueries(path); });
}

TEST_F(CorruptArtifactsTest, Trajectories) {
  ExpectText("a.tum", SomeTrajectory(), [](const Path& path) { ReadTum(path); });
}

TEST_F(CorruptArtifactsTest, PoseGraphs) {
  ExpectText("a.g2o", SomeGraph(), [](const Path& path) { ReadG2o(path); });
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

}  // namespace corrupt_artifacts_test
}  // namespace nightmap
