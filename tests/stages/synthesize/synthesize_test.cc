// SPDX-License-Identifier: Apache-2.0
#include "stages/synthesize/synthesize.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <set>

#include "pipeline/base/files.h"
#include "pipeline/io/image_io.h"
#include "stages/synthesize/write_site.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

SynthesizeOptions SmallSite() {
  SynthesizeOptions options;
  options.building.num_rooms = 3;
  options.building.light_map_cell_m = 0.6;
  options.building.num_light_samples = 2;
  options.camera.image_width_px = 64;
  options.camera.image_height_px = 48;
  options.camera.focal_length_px = 52;
  options.route.num_frames = 450;
  options.queries.num_queries = 5;
  return options;
}

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
  EXPECT_EQ(ReadGrayImage(folder / "labels/000007.png").pixels, frame.labels.pixels);
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

}  // namespace
}  // namespace nightmap
