// SPDX-License-Identifier: Apache-2.0
#include "stages/world/synthesize/synthesize.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/world/floor_plan.h"
#include "pipeline/world/route.h"
#include "pipeline/world/upward_motion.h"
#include "stages/world/synthesize/mislabel_things.h"

namespace nightmap {

namespace {

constexpr std::int64_t kFirstQuery_ns = 2'000'000'000'000;

std::int64_t Time_ns(std::int64_t first_ns, std::size_t idx, double frame_rate_hz) {
  return first_ns + std::llround(static_cast<double>(idx) * 1e9 / frame_rate_hz);
}

constexpr std::uint64_t kPictureStream = 601;
constexpr std::uint64_t kQueryPictureStream = 602;
constexpr std::uint64_t kUpwardPictureStream = 606;
constexpr std::uint64_t kUpwardMountStream = 607;

std::uint64_t NoiseSeed(const SynthesizeOptions& options, std::uint64_t stream, std::size_t idx) {
  const auto first_idx = static_cast<std::uint64_t>(options.recording) << 32;
  return Random(static_cast<std::uint64_t>(options.building.seed), stream, first_idx + idx).Next();
}

// No picture shows the light.
BuildingOptions Unlit(BuildingOptions options) {
  options.light_map_cell_m = 1;
  options.num_light_samples = 1;
  return options;
}

double SmallestClearance_m(const SynthesizeOptions& options, const SynthesizePlan& plan) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const StampedPose& frame : plan.frames) {
    const Eigen::Vector2d position = frame.pose.translation.head<2>();
    const double floor_m = frame.pose.translation.z() - options.camera.camera_height_m;
    smallest = std::min(smallest,
                        Clearance(plan.world.scene.boxes, position, floor_m + 0.05, floor_m + 1.5));
  }
  return smallest;
}

// building_from_camera of every upward picture.
std::vector<StampedPose> UpwardPoses(const SynthesizeOptions& options, const FloorLayout& layout) {
  const double rate_hz = options.upward.rate_hz;
  if (rate_hz <= 0 || !options.render) return {};
  const UpwardMotion motion(PlanDrive(layout, options.route, options.frame_rate_hz),
                            options.upward.mount,
                            NoiseSeed(options, kUpwardMountStream, 0));
  std::vector<StampedPose> poses;
  for (int i = 0; (i + 0.5) / rate_hz <= motion.Drive().Duration_s(); ++i) {
    const double time_s = (i + 0.5) / rate_hz;
    poses.push_back({kFirstFrame_ns + std::llround(time_s * 1e9), motion.CameraAt(time_s)});
  }
  return poses;
}

}  // namespace

SynthesizePlan PlanSynthesize(const SynthesizeOptions& options, int num_threads) {
  if (!options.render && options.scanner.rate_hz <= 0) {
    throw UsageError(
        "render = false and scan_rate_hz = 0 record nothing: set render = true, or a rate");
  }
  SynthesizePlan plan;
  // The route comes first, because it is quick and refuses contradictory options.
  const std::vector<Rigid3> route =
      PlanRoute(PlanLayout(options.building), options.route, options.camera);
  plan.world = BuildWorld(
      options.render ? options.building : Unlit(options.building), options.route, num_threads);
  for (std::size_t i = 0; i < route.size(); ++i) {
    plan.frames.push_back({Time_ns(kFirstFrame_ns, i, options.frame_rate_hz), route[i]});
  }
  plan.upward = UpwardPoses(options, plan.world.layout);
  if (options.render) {
    plan.query_details = PlanQueries(plan.world,
                                     route,
                                     options.camera,
                                     options.sensor,
                                     options.queries,
                                     options.building.seed,
                                     num_threads);
  }
  for (std::size_t i = 0; i < plan.query_details.size(); ++i) {
    plan.queries.push_back({Time_ns(kFirstQuery_ns, i, options.frame_rate_hz),
                            plan.query_details[i].building_from_camera});
  }
  for (int floor = 0; floor < options.building.num_floors; ++floor) {
    plan.floor_plans.push_back(TrueFloorPlan(plan.world, options.floor_plan, floor));
  }
  return plan;
}

void RunSynthesize(const SynthesizeOptions& options,
                   const SynthesizePlan& plan,
                   const FrameSink& sink,
                   Progress& progress,
                   int num_threads) {
  if (!options.render) return;
  const Camera camera = options.camera.Pinhole();
  const std::size_t num_frames = plan.frames.size();
  progress.Start(num_frames + plan.queries.size());
  ParallelFor(num_frames + plan.queries.size(), num_threads, [&](std::size_t i) {
    const bool is_query = i >= num_frames;
    const std::size_t idx = is_query ? i - num_frames : i;
    const StampedPose& stamped = is_query ? plan.queries[idx] : plan.frames[idx];
    const std::uint64_t noise_seed =
        NoiseSeed(options, is_query ? kQueryPictureStream : kPictureStream, idx);
    RenderedFrame frame = Render(plan.world,
                                 camera,
                                 stamped.pose,
                                 options.sensor,
                                 options.camera.color_noise_levels,
                                 noise_seed);
    MislabelThings(plan.world.scene, options.mislabelled_ratio, noise_seed, frame);
    sink(is_query, idx, frame);
    progress.Advance();
  });
  progress.Finish();
}

void RunUpward(const SynthesizeOptions& options,
               const SynthesizePlan& plan,
               const UpwardSink& sink,
               Progress& progress,
               int num_threads) {
  const Camera camera = options.upward.Pinhole();
  progress.Start(plan.upward.size());
  ParallelFor(plan.upward.size(), num_threads, [&](std::size_t i) {
    const RenderedFrame frame = Render(plan.world,
                                       camera,
                                       plan.upward[i].pose,
                                       options.sensor,
                                       options.camera.color_noise_levels,
                                       NoiseSeed(options, kUpwardPictureStream, i));
    sink(i, frame.color);
    progress.Advance();
  });
  progress.Finish();
}

nlohmann::json DescribePlan(const SynthesizeOptions& options, const SynthesizePlan& plan) {
  std::vector<double> steps_m;
  std::vector<double> turns_rad;
  double length_m = 0;
  for (std::size_t i = 1; i < plan.frames.size(); ++i) {
    const Rigid3& a = plan.frames[i - 1].pose;
    const Rigid3& b = plan.frames[i].pose;
    steps_m.push_back((b.translation - a.translation).norm());
    turns_rad.push_back(AngleBetween_rad(a, b));
    length_m += steps_m.back();
  }
  std::vector<double> offsets_m;
  std::vector<double> covisible_ratios;
  for (const SyntheticQuery& query : plan.query_details) {
    offsets_m.push_back(query.offset_m);
    covisible_ratios.push_back(query.covisible_ratio);
  }
  nlohmann::json report;
  report["num_floors"] = plan.world.layout.num_floors;
  report["num_rooms"] = plan.world.layout.rooms.size();
  report["num_identical_rooms"] =
      std::min(options.building.num_identical_rooms, options.building.num_rooms);
  report["num_boxes"] = plan.world.scene.boxes.size();
  report["num_surfaces"] = plan.world.scene.surfaces.size();
  report["num_textures"] = plan.world.scene.textures.size();
  report["indoor_area_m2"] = plan.world.layout.IndoorArea_m2();
  report["num_frames"] = options.render ? plan.frames.size() : 0;
  if (options.upward.rate_hz > 0) report["num_upward_pictures"] = plan.upward.size();
  report["route_length_m"] = length_m;
  report["route_clearance_m"] = SmallestClearance_m(options, plan);
  report["median_step_m"] = Median(steps_m);
  report["max_step_m"] = *std::max_element(steps_m.begin(), steps_m.end());
  report["median_turn_rad"] = Median(turns_rad);
  report["max_turn_rad"] = *std::max_element(turns_rad.begin(), turns_rad.end());
  report["num_queries"] = plan.queries.size();
  report["median_query_offset_m"] = Median(offsets_m);
  report["median_query_covisible_ratio"] = Median(covisible_ratios);
  return report;
}

}  // namespace nightmap
