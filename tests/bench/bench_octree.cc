// SPDX-License-Identifier: Apache-2.0
// The program of tests/bench/bench_octree.py. Builds one octree in one way from all depth of a
// mapped site's poses but every fifth, and prints as JSON what that took, how much it agrees with
// another octree, and with the rays of the poses kept out.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/dense/back_project.h"
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/dense/octree/occupancy_volume.h"
#include "stages/dense/octree/octomap_volume.h"
#include "stages/dense/octree/voxel_walk.h"
#include "tests/stages/dense/octree/voxel_states.h"

namespace nightmap {
namespace {

constexpr double kNoLimit_m = 100.0;
constexpr std::size_t kHoldOutEvery = 5;
constexpr int kNearEnd_voxels = 2;

struct BenchOptions {
  std::filesystem::path site, data, out, reference;
  std::string poses = "keyframes";
  std::string builder = "batched";
  bool discretize = false;
  int stride = 1;
  int num_threads = 1;
  double resolution_m = 0.04;
};

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double CpuTime_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// A size in /proc/self/status.
double Memory_mib(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) / 1024;
  }
  throw DataError("/proc/self/status has no {}", name);
}

KeyframeSource Open(const BenchOptions& options) {
  std::vector<std::filesystem::path> shards;
  for (const auto& file : std::filesystem::directory_iterator(options.site / "frames")) {
    if (file.path().filename().string().starts_with("shard_")) shards.push_back(file.path());
  }
  std::ranges::sort(shards);
  KeyframeSource source;
  source.cameras = ReadCameras(options.site / "adjust" / "cameras.json");
  source.keyframes = SelectKeyframes(ReadFrames(shards),
                                     source.cameras,
                                     ReadTum(options.site / "map_frame" / (options.poses + ".tum")),
                                     options.stride);
  source.load = [cameras = source.cameras, data = options.data](const Keyframe& keyframe) {
    const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
    return LoadRgbd(keyframe.frame, cameras[camera], data);
  };
  return source;
}

std::vector<KeyframeRays> LoadRays(const KeyframeSource& source) {
  DepthFilterOptions every_pixel;
  every_pixel.pixel_stride = 1;
  every_pixel.edge_radius_px = 0;
  every_pixel.max_incidence_rad = M_PI / 2;
  const std::vector<RayTable> rays = MakeRayTables(source.cameras, 2);
  std::vector<KeyframeRays> all_rays(source.keyframes.size());
  ParallelFor(all_rays.size(), 2, [&](std::size_t i) {
    const Keyframe& keyframe = source.keyframes[i];
    const RgbdImages images = source.load(keyframe);
    const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
    const auto points = BackProjectDepth(
        images.depth, images.color, rays[camera], source.cameras[camera], kNoLimit_m, every_pixel);
    all_rays[i].origin_in_map = keyframe.map_from_camera.translation;
    all_rays[i].points.reserve(points.size());
    for (const DepthPoint& point : points) {
      all_rays[i].points.push_back(
          {keyframe.map_from_camera * point.point_in_camera.cast<double>(), 0, point.rgb});
    }
  });
  return all_rays;
}

OccupancyTree Batched(const TraceOptions& options,
                      std::span<const KeyframeRays> all_rays,
                      int num_threads) {
  OccupancyVolume volume({});
  const std::size_t batch = 4 * static_cast<std::size_t>(num_threads);
  for (std::size_t begin = 0; begin < all_rays.size(); begin += batch) {
    std::vector<KeyframeEvidence> evidence(std::min(batch, all_rays.size() - begin));
    ParallelFor(evidence.size(), num_threads, [&](std::size_t i) {
      evidence[i] = TraceRays(all_rays[begin + i], options);
    });
    volume.Integrate(evidence, num_threads);
  }
  return volume.Leaves(options.resolution_m, num_threads);
}

// Time per keyframe and memory from its making to Stop().
class Meter {
 public:
  Meter() : before_mib_(Memory_mib("VmRSS")) {
    std::ofstream("/proc/self/clear_refs") << "5";  // forget the peak
    wall_s_ = -Now_s();
    cpu_s_ = -CpuTime_s();
  }
  void Stop(std::size_t num_keyframes, nlohmann::json& result) {
    wall_s_ += Now_s();
    cpu_s_ += CpuTime_s();
    result["wall_ms"] = 1e3 * wall_s_ / static_cast<double>(num_keyframes);
    result["cpu_ms"] = 1e3 * cpu_s_ / static_cast<double>(num_keyframes);
    result["peak_mib"] = Memory_mib("VmHWM") - before_mib_;
  }

 private:
  double before_mib_ = 0;
  double wall_s_ = 0;
  double cpu_s_ = 0;
};

OccupancyTree Build(const BenchOptions& options,
                    std::span<const KeyframeRays> all_rays,
                    nlohmann::json& result) {
  const TraceOptions trace{options.resolution_m, kNoLimit_m, options.discretize, std::nullopt};
  Meter meter;
  if (options.builder == "batched") {
    OccupancyTree tree = Batched(trace, all_rays, options.num_threads);
    meter.Stop(all_rays.size(), result);
    return tree;
  }
  OctomapVolume volume({}, trace);
  for (const KeyframeRays& rays : all_rays) volume.Insert(rays);
  meter.Stop(all_rays.size(), result);  // what OctoMap does to the tree afterwards is not counted
  return volume.Leaves();
}

// Share of the rays that end in an occupied voxel and pass none on the way to it.
double RayAgreement(const VoxelStates& states,
                    std::span<const KeyframeRays> all_rays,
                    double resolution_m) {
  std::size_t num_agreeing = 0;
  std::size_t num_rays = 0;
  for (const KeyframeRays& rays : all_rays) {
    const VoxelKey origin = VoxelOf(rays.origin_in_map, resolution_m);
    for (const RayEnd& point : rays.points) {
      const VoxelKey end = VoxelOf(point.point_in_map, resolution_m);
      bool agrees = states.Is(MortonCode(end), true);
      int num_passed = 0;
      const VoxelWalk walk(point.point_in_map / resolution_m,
                           (rays.origin_in_map - point.point_in_map) / resolution_m);
      walk.Visit((origin - end).cwiseAbs().sum(), [&](std::uint64_t voxel) {
        if (++num_passed > kNearEnd_voxels && states.Is(voxel, true)) agrees = false;
      });
      num_agreeing += agrees ? 1 : 0;
      ++num_rays;
    }
  }
  return static_cast<double>(num_agreeing) / static_cast<double>(num_rays);
}

void Run(const BenchOptions& options) {
  std::vector<KeyframeRays> all_rays;
  std::vector<KeyframeRays> held_out;
  std::size_t num_points = 0;
  for (KeyframeRays& rays : LoadRays(Open(options))) {
    const bool hold_out = (all_rays.size() + held_out.size()) % kHoldOutEvery == kHoldOutEvery - 1;
    if (!hold_out) num_points += rays.points.size();
    (hold_out ? held_out : all_rays).push_back(std::move(rays));
  }
  if (all_rays.empty()) throw DataError("{}: no poses with depth", options.site.string());
  nlohmann::json result;
  const OccupancyTree tree = Build(options, all_rays, result);
  result["num_frames"] = all_rays.size();
  result["points_per_frame"] = num_points / all_rays.size();
  if (!options.out.empty()) WriteOctree(options.out, tree);
  const VoxelStates states(tree);
  result["ray_agreement"] = RayAgreement(states, held_out, options.resolution_m);
  if (!options.reference.empty()) {
    const VoxelStates reference(ReadOctree(options.reference));
    result["iou_occupied"] = states.IntersectionOverUnion(reference, true);
    result["iou_free"] = states.IntersectionOverUnion(reference, false);
  }
  std::cout << result.dump() << "\n";
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  nightmap::BenchOptions options;
  CLI::App app("builds one octree and measures it");
  app.add_option("--site", options.site, "MAPS/SITE")->required();
  app.add_option("--data", options.data, "recordings")->required();
  app.add_option("--poses", options.poses, "keyframes or trajectory");
  app.add_option("--stride", options.stride, "every Nth pose");
  app.add_option("--builder", options.builder, "batched or octomap");
  app.add_flag("--discretize", options.discretize);
  app.add_option("--threads", options.num_threads);
  app.add_option("--resolution_m", options.resolution_m);
  app.add_option("--out", options.out, ".ot to write");
  app.add_option("--reference", options.reference, ".ot to compare with");
  CLI11_PARSE(app, argc, argv);
  try {
    nightmap::Run(options);
  } catch (const nightmap::DataError& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
