// SPDX-License-Identifier: Apache-2.0
// Options of the synthetic building, its camera, its route, its queries, and the robot's upward
// camera, laser and wheels.
#pragma once

#include <string>

#include "pipeline/base/options.h"
#include "pipeline/geometry/camera.h"

namespace nightmap {

struct BuildingOptions {
  int seed = 1;
  int num_rooms = 6;
  int num_identical_rooms = 2;
  double room_width_m = 3.0;
  double room_depth_m = 2.9;
  double corridor_width_m = 1.4;
  double wall_thickness_m = 0.1;
  double ceiling_height_m = 2.6;
  double door_width_m = 0.95;
  double repeated_panel_ratio = 0.25;
  bool mirrored_corridors = false;
  double blank_walls_length_m = 0;
  double ceiling_fittings_per_m2 = 0;
  int num_floors = 1;
  double slab_thickness_m = 0.3;
  double ramp_slope = 0.3;
  double light_map_cell_m = 0.1;
  int num_light_samples = 32;
  void Register(OptionList& list);
};

struct SyntheticCameraOptions {
  int image_width_px = 640;
  int image_height_px = 480;
  double focal_length_px = 525;
  double camera_height_m = 1.0;
  double pitch_rad = 0.16;
  double color_noise_levels = 2.0;
  void Register(OptionList& list);
  Camera Pinhole() const;  // principal point at the centre, no distortion
};

// How a camera that looks straight up is mounted on the robot.
struct UpwardMountOptions {
  double camera_height_m = 0.35;
  double mount_tilt_rad = 0.01;
  double vibration_rad = 0.002;
  void Register(OptionList& list, const std::string& prefix = "");  // of the options' names
};

// The camera on the robot that looks at the ceiling.
struct UpwardCameraOptions {
  double rate_hz = 0;
  int image_width_px = 640;
  int image_height_px = 480;
  double focal_length_px = 320;
  UpwardMountOptions mount;
  void Register(OptionList& list);
  Camera Pinhole() const;  // principal point at the centre, no distortion
};

struct DepthSensorOptions {
  double min_depth_m = 0.4;
  double max_depth_m = 5.0;
  double noise_constant_m = 0.0012;
  double noise_quadratic_per_m = 0.0019;
  double baseline_m = 0.075;
  double disparity_step_px = 0.125;
  double max_incidence_rad = 1.4;
  double edge_hole_ratio = 0.6;
  double dropout_ratio = 0.002;
  void Register(OptionList& list);
};

struct RouteOptions {
  int num_frames = 700;
  int num_laps = 1;
  double clearance_m = 0.35;
  double start_ratio = 0;
  double length_ratio = 1;
  double overlap_m = 1.5;
  double corner_radius_m = 0.2;
  double max_step_m = 0.105;
  double max_turn_rad = 0.11;
  bool differential_drive = false;
  void Register(OptionList& list);
};

struct QueryOptions {
  int num_queries = 60;
  double min_offset_m = 0.2;
  double max_offset_m = 0.6;
  double max_heading_change_rad = 0.436;
  double max_height_change_m = 0.1;
  double clearance_m = 0.3;
  double min_covisible_ratio = 0.5;
  void Register(OptionList& list);
};

struct FloorPlanOptions {
  double cell_m = 0.05;
  double min_height_m = 0.1;
  double max_height_m = 1.5;
  void Register(OptionList& list);
};

struct ScannerOptions {
  double rate_hz = 0;
  double start_s = 0;
  double field_of_view_deg = 180;
  int num_beams = 180;
  double max_range_m = 30;
  double height_m = 0.3;
  double duration_s = 0.0133;
  double noise_constant_m = 0.01;
  double noise_per_m = 0.002;
  double miss_ratio = 0.005;
  double glass_ratio = 0.03;
  double black_ratio = 0.03;
  double black_range_m = 3;
  int num_walkers = 0;
  void Register(OptionList& list);
};

struct WheelOptions {
  double rate_hz = 20;
  double scale_bias = 0.01;
  double heading_bias_rad_per_m = 0.002;
  double distance_noise_m = 0.01;
  double heading_noise_rad = 0.01;
  double heading_noise_rad_per_root_m = 0;
  void Register(OptionList& list);
};

// A stretch of the drive on which the wheels slip.
struct WheelSlipOptions {
  double at_s = 0;
  double duration_s = 2;
  double ratio = 0;
  void Register(OptionList& list);
};

}  // namespace nightmap
