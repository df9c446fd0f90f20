// SPDX-License-Identifier: Apache-2.0
// synthesize_ceiling: makes up the recording of a differential-drive robot with a camera that looks
// straight up, and wheel odometry, with exact truth.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/world/synthetic_options.h"
#include "pipeline/world/upward_motion.h"
#include "pipeline/world/wheel_odometry.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_render.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_route.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_world.h"

namespace nightmap {

// The time of the first frame and of the first sample of the wheels.
inline constexpr std::int64_t kFirstCeilingFrame_ns = 1'000'000'000'000;

struct SynthesizeCeilingOptions {
  int seed = 1;
  int noise_seed = 0;
  std::string layout = "corridor";
  double blank_length_m = 8;
  double overlap_m = 12;
  double duration_s = 0;
  int image_width_px = 640;
  int image_height_px = 480;
  double focal_length_px = 320;
  double frame_rate_hz = 10;
  double exposure_s = 0.01;
  double color_noise_levels = 2;
  double vignetting = 0.25;
  double light_change = 0.15;
  UpwardMountOptions mount;
  CeilingRouteOptions route;
  WheelOptions wheels = CeilingWheels();
  double scale_bias_sigma = 0.005;
  double heading_bias_sigma_rad_per_m = 0.002;
  WheelSlipOptions slip;

  static WheelOptions CeilingWheels();
  void Register(OptionList& list);
  Camera Pinhole() const;           // principal point at the centre, no distortion
  std::uint64_t NoiseSeed() const;  // decides all but the building
};

// Everything but the pictures. The stamp of a frame is the middle of its exposure.
struct CeilingRecording {
  CeilingWorld world;
  UpwardMotion motion;
  WheelOptions wheels;                            // with the biases that were drawn
  WheelOdometry odometry;                         // x m, y m, heading rad; the first sample is 0
  std::vector<StampedPose> building_from_robot;   // at every frame
  std::vector<StampedPose> building_from_camera;  // likewise
  std::vector<double> gains;                      // of the sensor, likewise
};

// Throws UsageError when the options contradict each other. Does not depend on num_threads.
CeilingRecording PlanCeilingRecording(const SynthesizeCeilingOptions& options, int num_threads);

// Measurements of the wheels on a drive, and the options with the biases that noise_seed draws.
WheelOptions DrawWheelBiases(const SynthesizeCeilingOptions& options);
WheelOdometry DriveWheels(const RobotDrive& drive,
                          const SynthesizeCeilingOptions& options,
                          const WheelOptions& wheels);

// The sensor's gain of every frame: an automatic exposure, which follows the mean brightness within
// 0.3 s, times a light that changes slowly by at most the share `light_change`.
std::vector<double> CeilingGains(const CeilingWorld& world,
                                 const std::vector<StampedPose>& building_from_camera,
                                 const SynthesizeCeilingOptions& options,
                                 int num_threads);

// Picture `idx` of the recording. Motion blurs it: 2 or 4 times within the exposure are averaged
// where the picture moves by more than 0.5 or 2 px meanwhile.
ColorImage RenderCeilingFrame(const SynthesizeCeilingOptions& options,
                              const CeilingRecording& recording,
                              std::size_t idx);

// Receives each picture once, from any thread and in any order.
using CeilingFrameSink = std::function<void(std::size_t idx, const ColorImage& picture)>;

// Renders all pictures. They do not depend on num_threads.
void RunSynthesizeCeiling(const SynthesizeCeilingOptions& options,
                          const CeilingRecording& recording,
                          const CeilingFrameSink& sink,
                          Progress& progress,
                          int num_threads);

// Counts and figures for report.json.
nlohmann::json DescribeCeilingRecording(const CeilingRecording& recording);

}  // namespace nightmap
