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
  OPTION(int, seed, 1, {0, 1e9}, "decides the building");
  OPTION(int, noise_seed, 0, {0, 1e9},
         "decides all but the building: tilt, vibration, light, noise; 0: the same as seed");
  OPTION(std::string, layout, "corridor", {"corridor", "office"}, "a loop of corridors; six rooms");
  // Corridor: length of the stretch where neither ceiling nor walls show anything.
  double blank_length_m = 8;
  OPTION(double, overlap_m, 12, {6, 30},
         "corridor: way that the robot drives on after one loop, before it turns back for 5 m");
  OPTION(double, duration_s, 0, {0, 1e5}, "ends the recording early; 0: whole route");
  OPTION(int, image_width_px, 640, {16, 8192}, "columns of a picture");
  OPTION(int, image_height_px, 480, {16, 8192}, "rows of a picture");
  OPTION(double, focal_length_px, 320, {4, 1e5}, "focal length of the pinhole");
  OPTION(double, frame_rate_hz, 10, {0.1, 1000}, "pictures per second");
  double exposure_s = 0.01;  // time over which motion blurs a picture
  OPTION(double, color_noise_levels, 2, {0, 64},
         "sigma of the noise of each channel of a pixel, of 255");
  double vignetting = 0.25;  // share of the light that the corners lack
  OPTION(double, light_change, 0.15, {0, 0.9}, "share by which brightness rises and falls slowly");
  OPTIONS_OF(UpwardMountOptions, mount);
  OPTIONS_OF(CeilingRouteOptions, route);
  WheelOptions wheels = CeilingWheels();
  OPTIONS_AT(wheels, "wheel_");
  // Sigmas of what a draw by noise_seed adds to wheel_scale_bias and wheel_heading_bias_rad_per_m.
  double scale_bias_sigma = 0.005;
  double heading_bias_sigma_rad_per_m = 0.002;
  WheelSlipOptions slip;

  static WheelOptions CeilingWheels();
  Camera Pinhole() const {
    return CenteredPinhole(image_width_px, image_height_px, focal_length_px);
  }
  std::uint64_t NoiseSeed() const;  // decides all but the building
  REGISTER_OPTIONS();
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
