// SPDX-License-Identifier: Apache-2.0
#include "stages/world/synthesize/synthesize.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/image_io.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/read_signals.h"
#include "pipeline/world/robot_drive.h"
#include "stages/world/synthesize/robot_recording.h"
#include "stages/world/synthesize/write_site.h"
#include "tests/stages/world/synthesize/small_site.h"

namespace nightmap::synthesize_test {

namespace fs = std::filesystem;

// Hashes of all pictures, by (is_query, idx).
std::map<std::pair<bool, std::size_t>, std::string> Hashes(const SynthesizeOptions& options,
                                                           int num_threads) {
  const SynthesizePlan plan = PlanSynthesize(options, num_threads);
  std::map<std::pair<bool, std::size_t>, std::string> hashes;
  std::mutex mutex;
  Progress progress("test", false);
  const auto sink = [&](bool is_query, std::size_t idx, const RenderedFrame& frame) {
    std::string bytes(frame.color.pixels.begin(), frame.color.pixels.end());
    bytes.append(frame.labels.pixels.begin(), frame.labels.pixels.end());
    for (const float depth_m : frame.depth.pixels) bytes += std::to_string(depth_m);
    const std::lock_guard lock(mutex);
    EXPECT_TRUE(hashes.emplace(std::pair{is_query, idx}, HashBytes(bytes)).second);
  };
  RunSynthesize(options, plan, sink, progress, num_threads);
  return hashes;
}

SynthesizeOptions LaserSite() {
  SynthesizeOptions options = SmallSite();
  options.render = false;
  options.scanner.rate_hz = 7;
  options.scanner.field_of_view_deg = 360;
  options.scanner.num_beams = 90;
  options.scanner.num_walkers = 2;
  return options;
}

// The building and the recording of LaserSite(), made once for all tests.
const SynthesizePlan& Planned() {
  static const SynthesizePlan plan = PlanSynthesize(LaserSite(), 2);
  return plan;
}

const RobotRecording& Recorded() {
  static const RobotRecording recording = RecordRobot(LaserSite(), Planned(), 2);
  return recording;
}

std::set<std::string> NamesOfFiles(const SynthesizeOptions& options) {
  std::set<std::string> names;
  for (const auto& [name, bytes] : ListsAndTruth(options, PlanSynthesize(options, 2))) {
    EXPECT_TRUE(names.insert(name).second);
    EXPECT_FALSE(bytes.empty());
  }
  return names;
}

TEST(Synthesize, PicturesDoNotDependOnThreads) {
  const auto one = Hashes(SmallSite(), 1);
  EXPECT_EQ(one.size(), 455U);
  EXPECT_EQ(one, Hashes(SmallSite(), 2));
}

TEST(Synthesize, TimesAreUniqueAndAscend) {
  const SynthesizePlan plan = PlanSynthesize(SmallSite(), 2);
  std::set<std::int64_t> times_ns;
  for (const auto* poses : {&plan.frames, &plan.queries}) {
    for (std::size_t i = 0; i < poses->size(); ++i) {
      EXPECT_TRUE(times_ns.insert((*poses)[i].time_ns).second);
      if (i == 0) continue;
      EXPECT_LT((*poses)[i - 1].time_ns, (*poses)[i].time_ns);
    }
  }
}

TEST(Synthesize, FilesHoldTheRenderedFrame) {
  const SynthesizeOptions options = SmallSite();
  const SynthesizePlan plan = PlanSynthesize(options, 2);
  const RenderedFrame frame =
      Render(plan.world, options.camera.Pinhole(), plan.frames[7].pose, options.sensor, 2.0, 1);
  const fs::path folder = fs::path(testing::TempDir()) / "nightmap_synthesize_test";
  for (const char* name : {"rgb", "depth", "labels"}) fs::create_directories(folder / name);
  const WritingFolder writing(folder);
  WriteFrame(folder, writing, 7, frame);
  const std::string first_hash = HashFile(folder / "rgb/000007.jpg");
  WriteFrame(folder, writing, 7, frame);
  EXPECT_EQ(HashFile(folder / "rgb/000007.jpg"), first_hash);
  EXPECT_EQ(ReadLabelImage(folder / "labels/000007.png").pixels, frame.labels.pixels);
  const RawDepthImage raw = ReadRawDepth(folder / "depth/000007.png");
  ASSERT_EQ(raw.pixels.size(), frame.depth.pixels.size());
  for (std::size_t i = 0; i < raw.pixels.size(); ++i) {
    EXPECT_NEAR(raw.pixels[i] / 5000.0, frame.depth.pixels[i], 1.001e-4);
  }
  const ColorImage color = ReadColorImage(folder / "rgb/000007.jpg");
  double difference = 0;
  for (std::size_t i = 0; i < color.pixels.size(); ++i) {
    difference += std::abs(color.pixels[i] - frame.color.pixels[i]);
  }
  EXPECT_LT(difference / static_cast<double>(color.pixels.size()), 8.0);
  fs::remove_all(folder);
}

TEST(Synthesize, TruthMeshHasTheStatedSize) {
  const SynthesizePlan plan = PlanSynthesize(SmallSite(), 2);
  const std::string bytes = TruthMesh(plan.world);
  const std::size_t num_surfaces = plan.world.scene.surfaces.size();
  const std::size_t header = bytes.find("end_header\n") + std::string("end_header\n").size();
  EXPECT_EQ(bytes.size() - header, num_surfaces * (4 * 12 + 2 * 14));
}

TEST(Synthesize, TruthJsonListsEveryBox) {
  const SynthesizePlan plan = PlanSynthesize(SmallSite(), 2);
  const auto json = nlohmann::json::parse(TruthJson(plan.world));
  EXPECT_EQ(json["boxes"].size(), plan.world.scene.boxes.size());
  EXPECT_GT(json["rectangles"].size(), 6U);
}

TEST(Synthesize, TruthJsonListsEveryThing) {
  const auto json = nlohmann::json::parse(TruthJson(Planned().world));
  const std::set<std::string> classes = {"table", "chair", "shelf", "cabinet", "bed", "sofa"};
  std::set<std::pair<int, int>> of_boxes, of_things;  // piece and label
  for (const auto& box : json["boxes"]) {
    const std::string name = json["labels"].at(box["label"].get<std::size_t>());
    if (classes.contains(name)) of_boxes.emplace(box["piece"], box["label"]);
    EXPECT_EQ(box["piece"] == -1, name == "wall");
  }
  for (const auto& thing : json["things"]) {
    EXPECT_TRUE(of_things.emplace(thing["piece"], thing["label"]).second);
    EXPECT_EQ(thing["class"], json["labels"].at(thing["label"].get<std::size_t>()));
    EXPECT_EQ(thing["center_m"].size(), 3U);
    EXPECT_EQ(thing["half_size_m"].size(), 3U);
    EXPECT_TRUE(thing["yaw_rad"].is_number());
  }
  EXPECT_EQ(of_things, of_boxes);
  EXPECT_GT(of_things.size(), 5U);
}

// Wrong labels change the labels alone, whatever the number of threads.
TEST(Synthesize, MislabelsOnlyTheLabels) {
  SynthesizeOptions options = SmallSite();
  const SynthesizePlan plan = PlanSynthesize(options, 2);
  const auto render = [&](double mislabelled_ratio, int num_threads) {
    options.mislabelled_ratio = mislabelled_ratio;
    std::vector<RenderedFrame> frames(plan.frames.size() + plan.queries.size());
    Progress progress("test", false);
    const auto sink = [&](bool is_query, std::size_t idx, const RenderedFrame& frame) {
      frames[is_query ? plan.frames.size() + idx : idx] = frame;
    };
    RunSynthesize(options, plan, sink, progress, num_threads);
    return frames;
  };
  const std::vector<RenderedFrame> right = render(0, 2);
  const std::vector<RenderedFrame> wrong = render(0.3, 2);
  const std::vector<RenderedFrame> again = render(0.3, 1);
  std::size_t num_mislabelled = 0;
  for (std::size_t i = 0; i < right.size(); ++i) {
    EXPECT_EQ(wrong[i].color.pixels, right[i].color.pixels);
    EXPECT_EQ(wrong[i].depth.pixels, right[i].depth.pixels);
    EXPECT_EQ(wrong[i].labels.pixels, again[i].labels.pixels);
    num_mislabelled += wrong[i].labels.pixels != right[i].labels.pixels ? 1 : 0;
  }
  EXPECT_GT(num_mislabelled, right.size() / 4);
}

// The laser changes nothing of the pictures, lists and truth.
TEST(Synthesize, RecordingWithLaserHasTheSameFramesAndFiles) {
  SynthesizeOptions options = SmallSite();
  const SynthesizePlan before = PlanSynthesize(options, 2);
  const auto files_before = ListsAndTruth(options, before);
  const nlohmann::json report_before = DescribePlan(options, before);
  options.scanner.rate_hz = 10;
  options.scanner.num_walkers = 2;
  const SynthesizePlan after = PlanSynthesize(options, 2);
  const auto files_after = ListsAndTruth(options, after);
  ASSERT_EQ(files_after.size(), files_before.size());
  for (std::size_t i = 0; i < files_before.size(); ++i) {
    EXPECT_EQ(files_after[i].name, files_before[i].name);
    EXPECT_EQ(files_after[i].bytes, files_before[i].bytes) << files_before[i].name;
  }
  EXPECT_EQ(DescribePlan(options, after), report_before);
}

TEST(Synthesize, WithoutPicturesOnlyTheTruthIsListed) {
  EXPECT_EQ(NamesOfFiles(LaserSite()),
            (std::set<std::string>{"truth/boxes.json",
                                   "truth/floor_plan.pgm",
                                   "truth/floor_plan.yaml",
                                   "truth/surfaces.ply"}));
  const SynthesizePlan& plan = Planned();
  EXPECT_TRUE(plan.queries.empty());
  Progress progress("test", false);
  const auto sink = [](bool, std::size_t, const RenderedFrame&) { FAIL() << "a picture"; };
  RunSynthesize(LaserSite(), plan, sink, progress, 2);
  EXPECT_EQ(DescribePlan(LaserSite(), plan)["num_frames"], 0);
}

TEST(Synthesize, TheTruthDoesNotDependOnPictures) {
  SynthesizeOptions options = LaserSite();
  const SynthesizePlan& unlit = Planned();
  options.render = true;
  const SynthesizePlan lit = PlanSynthesize(options, 2);
  EXPECT_EQ(TruthJson(unlit.world), TruthJson(lit.world));
  EXPECT_EQ(TruthMesh(unlit.world), TruthMesh(lit.world));
  EXPECT_EQ(CarmenLog(RecordRobot(options, lit, 2)), CarmenLog(Recorded()));
}

TEST(Synthesize, RefusesToRecordNothing) {
  SynthesizeOptions options = SmallSite();
  options.render = false;
  EXPECT_THROW(PlanSynthesize(options, 1), UsageError);
}

TEST(RobotRecording, DoesNotDependOnThreads) {
  for (const int num_threads : {1, 4}) {
    const RobotRecording again = RecordRobot(LaserSite(), Planned(), num_threads);
    EXPECT_EQ(CarmenLog(again), CarmenLog(Recorded()));
    EXPECT_EQ(RobotTruth(again), RobotTruth(Recorded()));
  }
}

TEST(RobotRecording, AnotherRecordingOfTheBuildingHasOtherNoise) {
  SynthesizeOptions options = LaserSite();
  options.recording = 1;
  const RobotRecording other = RecordRobot(options, Planned(), 2);
  ASSERT_EQ(other.scans.size(), Recorded().scans.size());
  EXPECT_EQ(RobotTruth(other), RobotTruth(Recorded()));
  EXPECT_NE(other.scans[5].ranges_m, Recorded().scans[5].ranges_m);
  EXPECT_NE(other.scans[5].odometry, Recorded().scans[5].odometry);
}

// nightmap's own reader gets from the log what was recorded.
TEST(RobotRecording, LogIsReadAsItWasRecorded) {
  SensorConfig laser, wheels;
  laser.kind = SignalKind::kScan;
  laser.start_angle_deg = -180;
  laser.angle_step_deg = 4;
  laser.max_range_m = 30;
  wheels.kind = SignalKind::kOdometry;
  wheels.measures = "pose";
  std::vector<SignalSample> scans, samples;
  std::int64_t last_ns = 0;
  std::istringstream log(CarmenLog(Recorded()));
  for (std::string line; std::getline(log, line);) {
    if (line.starts_with('#')) continue;
    const auto words = SplitWords(line);
    const bool is_scan = words[0] == "FLASER";
    SignalSample sample = ParseCarmenLine(is_scan ? laser : wheels, LineTime::kNeeded, words);
    EXPECT_LE(last_ns, sample.time_ns);
    last_ns = sample.time_ns;
    if (is_scan) {
      const Eigen::Vector3d odometry = ParseCarmenLine(wheels, LineTime::kNeeded, words).value;
      EXPECT_LT((odometry - Recorded().scans[scans.size()].odometry).norm(), 2e-6);
    }
    (is_scan ? scans : samples).push_back(std::move(sample));
  }
  ASSERT_EQ(scans.size(), Recorded().scans.size());
  ASSERT_EQ(samples.size(), Recorded().wheels.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const RobotScan& scan = Recorded().scans[i];
    EXPECT_EQ(scans[i].time_ns, scan.time_ns);
    ASSERT_EQ(scans[i].ranges_m.size(), 90U);
    for (std::size_t k = 0; k < 90; ++k) {
      EXPECT_NEAR(scans[i].ranges_m[k], scan.ranges_m[k], 0.00051);
    }
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].time_ns, Recorded().wheels[i].time_ns);
    EXPECT_LT((samples[i].value - Recorded().wheels[i].odometry).norm(), 2e-6);
  }
}

// The robot stands below the camera, on the floor, at the frames' times.
TEST(RobotRecording, TruthIsBelowTheCamera) {
  SynthesizeOptions options = LaserSite();
  options.scanner.rate_hz = options.frame_rate_hz;
  const SynthesizePlan& plan = Planned();
  const RobotRecording recording = RecordRobot(options, plan, 2);
  ASSERT_EQ(recording.scans.size(), plan.frames.size() - 1);  // the last would end too late
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const Rigid3 robot = RobotPose(recording.scans[i].robot);
    const Rigid3& camera = plan.frames[i].pose;
    EXPECT_EQ(recording.scans[i].time_ns, plan.frames[i].time_ns);
    EXPECT_LT((robot.translation - camera.translation).head<2>().norm(), 1e-9);
    EXPECT_EQ(robot.translation.z(), 0);
    const Eigen::Vector3d view = camera.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d forward = robot.rotation * Eigen::Vector3d::UnitX();
    EXPECT_GT(view.head<2>().normalized().dot(forward.head<2>()), 1 - 1e-6);
  }
}

TEST(RobotRecording, RefusesScansThatOverlap) {
  SynthesizeOptions options = LaserSite();
  options.scanner.duration_s = 0.2;
  EXPECT_THROW(RecordRobot(options, Planned(), 1), UsageError);
}

TEST(ClearRecording, RemovesWhatTheOptionsDoNotMake) {
  const fs::path folder = fs::path(testing::TempDir()) / "nightmap_clear_recording_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const fs::path summary = folder / "synthesize.json";
  ClearRecording(summary, SmallSite());
  EXPECT_TRUE(fs::is_directory(folder / "queries/rgb"));
  for (const char* name : {"rgb.txt", "robot.log", "robot_groundtruth.txt", "rgb/1.jpg"}) {
    WriteFile(folder / name, "of earlier options");
  }
  ClearRecording(summary, SmallSite());
  EXPECT_TRUE(fs::exists(folder / "rgb.txt"));
  EXPECT_FALSE(fs::exists(folder / "rgb/1.jpg"));
  EXPECT_FALSE(fs::exists(folder / "robot.log"));
  EXPECT_FALSE(fs::exists(folder / "robot_groundtruth.txt"));
  WriteFile(folder / "robot.log", "of these options");
  ClearRecording(summary, LaserSite());
  EXPECT_TRUE(fs::exists(folder / "robot.log"));
  for (const char* name : {"rgb.txt", "rgb", "depth", "labels", "queries"}) {
    EXPECT_FALSE(fs::exists(folder / name)) << name;
  }
  fs::remove(folder / ".made_by_synthesize");
  EXPECT_THROW(ClearRecording(summary, LaserSite()), DataError);
  EXPECT_TRUE(fs::exists(folder / "robot.log"));
  fs::remove_all(folder);
}

}  // namespace nightmap::synthesize_test
