// SPDX-License-Identifier: Apache-2.0
// synthesize: renders an RGB-D recording of a synthetic building, with exact ground truth.
// pipeline/world holds the building, the route, the sensor model and the queries.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/world/plan_queries.h"
#include "pipeline/world/render.h"
#include "pipeline/world/synthetic_world.h"

namespace nightmap {

// The time of the first frame; the robot's laser and wheels begin at it too.
inline constexpr std::int64_t kFirstFrame_ns = 1'000'000'000'000;

struct SynthesizeOptions {
  OPTIONS_OF(BuildingOptions, building);
  OPTIONS_OF(SyntheticCameraOptions, camera);
  OPTIONS_OF(UpwardCameraOptions, upward, "upward_");
  OPTIONS_OF(DepthSensorOptions, sensor);
  OPTION(double, frame_rate_hz, 10, {0.1, 1000}, "frames per second in the timestamps");
  OPTION(int, recording, 0, {0, 1000},
         "number of the recording; recordings of one building with different numbers differ in "
         "noise");
  OPTION(bool, render, true, "renders pictures; false: only the laser and the wheels record");
  OPTION(double, mislabelled_ratio, 0, {0, 1},
         "share of the tables, chairs, shelves, cabinets, beds and sofas in a picture that its "
         "labels take for another of these");
  OPTIONS_OF(RouteOptions, route);
  OPTIONS_OF(QueryOptions, queries);
  OPTIONS_OF(FloorPlanOptions, floor_plan, "floor_plan_");
  OPTIONS_OF(ScannerOptions, scanner, "scan_");
  OPTION_AT("num_walkers", scanner.num_walkers, {0, 1000},
            "people who walk back and forth near the robot's route; the laser sees their legs, "
            "pictures do not show them");
  OPTIONS_OF(WheelOptions, wheels, "wheel_");
  REGISTER_OPTIONS();
};

// Everything that is fixed before any picture is rendered. Times are unique over frames and
// queries. Upward pictures begin half their period after the first frame. Without `render` there
// are no queries, and no picture shows the frames.
struct SynthesizePlan {
  SyntheticWorld world;
  std::vector<StampedPose> frames;   // building_from_camera
  std::vector<StampedPose> queries;  // building_from_camera
  std::vector<StampedPose> upward;   // building_from_camera of the upward camera
  std::vector<SyntheticQuery> query_details;
  std::vector<OccupancyGrid> floor_plans;  // the lowest floor first
};

// Throws UsageError when the options contradict each other.
SynthesizePlan PlanSynthesize(const SynthesizeOptions& options, int num_threads);

// Receives each picture once, from any thread and in any order; `is_query` tells the two lists
// apart.
using FrameSink = std::function<void(bool is_query, std::size_t idx, const RenderedFrame& frame)>;

// Renders all frames, then all queries; none without `render`. The pictures do not depend on
// num_threads.
void RunSynthesize(const SynthesizeOptions& options,
                   const SynthesizePlan& plan,
                   const FrameSink& sink,
                   Progress& progress,
                   int num_threads);

// Receives each upward picture once, from any thread and in any order.
using UpwardSink = std::function<void(std::size_t idx, const ColorImage& picture)>;

// Renders what the upward camera sees. The pictures do not depend on num_threads.
void RunUpward(const SynthesizeOptions& options,
               const SynthesizePlan& plan,
               const UpwardSink& sink,
               Progress& progress,
               int num_threads);

// Counts and figures of the plan for report.json: lengths, areas, motion between frames.
nlohmann::json DescribePlan(const SynthesizeOptions& options, const SynthesizePlan& plan);

}  // namespace nightmap
