// SPDX-License-Identifier: Apache-2.0
// Options of the synthetic building, its camera, its route, its queries, and the robot's upward
// camera, laser and wheels.
#pragma once

#include <string>

#include "pipeline/base/options.h"
#include "pipeline/geometry/camera.h"

namespace nightmap {

struct BuildingOptions {
  OPTION(int, seed, 1, {0, 2e9}, "seed of everything random in the building and its recording");
  OPTION(int, num_rooms, 6, {1, 300}, "rooms around and inside the corridor loop");
  OPTION(int, num_identical_rooms, 2, {0, 300},
         "rooms that share one furnishing and one set of pictures (perceptual aliasing)");
  OPTION(double, room_width_m, 3.0, {2.8, 12}, "inner width of a room, along the corridor");
  OPTION(double, room_depth_m, 2.9, {2.6, 12}, "inner depth of a room");
  OPTION(double, corridor_width_m, 1.4, {1.3, 5}, "inner width of the corridor");
  double wall_thickness_m = 0.1;  // thickness of every wall
  OPTION(double, ceiling_height_m, 2.6, {2.3, 5}, "height from floor to ceiling");
  double door_width_m = 0.95;  // clear width of a doorway
  // Share of the corridor's pictures that are the same notice board.
  double repeated_panel_ratio = 0.25;
  OPTION(bool, mirrored_corridors, false,
         "furnishes opposite corridors alike, so that the building looks the same after a half "
         "turn");
  OPTION(double, blank_walls_length_m, 0, {0, 12},
         "length of the stretch in the middle of the east corridor where walls and floor are of "
         "one color; at most room_depth_m");
  OPTION(double, ceiling_fittings_per_m2, 0, {0, 4},
         "vents, hatches, smoke detectors, sprinklers and tiles of another tone in the ceilings");
  OPTION(int, num_floors, 1, {1, 2},
         "storeys of the same layout, furnished differently; a ramp west of them joins two");
  double slab_thickness_m = 0.3;  // distance from a ceiling to the floor above it
  double ramp_slope = 0.3;        // rise of the ramp over its run
  OPTION(double, light_map_cell_m, 0.1, {0.02, 1}, "spacing of baked light samples");
  OPTION(int, num_light_samples, 32, {1, 1024}, "rays per baked light sample");
  REGISTER_OPTIONS();
};

// Focal length fx = fy, principal point at the centre, no distortion.
Camera CenteredPinhole(int width_px, int height_px, double focal_length_px);

struct SyntheticCameraOptions {
  OPTION(int, image_width_px, 640, {32, 4096}, "width of color, depth and labels");
  OPTION(int, image_height_px, 480, {32, 4096}, "height of color, depth and labels");
  OPTION(double, focal_length_px, 525, {10, 10000}, "fx = fy of color and depth");
  OPTION(double, camera_height_m, 1.0, {0.2, 2}, "camera above the floor");
  OPTION(double, pitch_rad, 0.16, {-0.8, 0.8}, "downward tilt of the camera");
  OPTION(double, color_noise_levels, 2.0, {0, 30},
         "standard deviation of the color noise, in 8-bit levels");

  Camera Pinhole() const {
    return CenteredPinhole(image_width_px, image_height_px, focal_length_px);
  }
  REGISTER_OPTIONS();
};

// How a camera that looks straight up is mounted on the robot.
struct UpwardMountOptions {
  OPTION(double, camera_height_m, 0.35, {0.05, 1.9}, "camera above the floor");
  OPTION(double, mount_tilt_rad, 0.01, {0, 0.2},
         "sigma of the roll and pitch by which the camera is mounted");
  OPTION(double, vibration_rad, 0.002, {0, 0.05},
         "sigma of the roll and pitch by which the camera shakes; correlated over 0.05 s");
  REGISTER_OPTIONS();
};

// The camera on the robot that looks at the ceiling.
struct UpwardCameraOptions {
  OPTION(double, rate_hz, 0, {0, 1000},
         "pictures per second of the robot's camera that looks straight up; 0: it has none");
  int image_width_px = 640;      // columns of its pictures
  int image_height_px = 480;     // rows of its pictures
  double focal_length_px = 320;  // its focal length, fx = fy
  OPTIONS_OF(UpwardMountOptions, mount);

  Camera Pinhole() const {
    return CenteredPinhole(image_width_px, image_height_px, focal_length_px);
  }
  REGISTER_OPTIONS();
};

struct DepthSensorOptions {
  OPTION(double, min_depth_m, 0.4, {0, 5}, "nearest depth measured");
  OPTION(double, max_depth_m, 5.0, {0.5, 13}, "farthest depth measured");
  OPTION(double, noise_constant_m, 0.0012, {0, 0.1}, "depth noise at 0.4 m");
  OPTION(double, noise_quadratic_per_m, 0.0019, {0, 0.1},
         "sigma = noise_constant_m + noise_quadratic_per_m (z - 0.4 m)^2");
  double baseline_m = 0.075;  // distance from projector to sensor, for the quantization
  OPTION(double, disparity_step_px, 0.125, {0, 2}, "disparity quantum; 0: none");
  OPTION(double, max_incidence_rad, 1.4, {0.1, 1.5708},
         "surfaces seen at a more grazing angle give no depth");
  OPTION(double, edge_hole_ratio, 0.6, {0, 1}, "share of depth-edge pixels that are lost");
  OPTION(double, dropout_ratio, 0.002, {0, 1}, "share of all pixels that are lost at random");
  REGISTER_OPTIONS();
};

struct RouteOptions {
  OPTION(int, num_frames, 700, {2, 1e6}, "frames of the recording");
  OPTION(int, num_laps, 1, {1, 20}, "number of times the robot goes through all rooms");
  OPTION(double, clearance_m, 0.35, {0.2, 0.45}, "smallest distance from the route to an obstacle");
  OPTION(double, start_ratio, 0, {0, 1},
         "position on the route where the recording begins, as a share of the route");
  OPTION(double, length_ratio, 1, {0.01, 1}, "share of the route that is recorded");
  OPTION(double, overlap_m, 1.5, {0, 20}, "distance driven beyond length_ratio");
  OPTION(double, max_step_m, 0.105, {0.001, 1}, "largest motion between two frames");
  OPTION(double, max_turn_rad, 0.11, {0.001, 1}, "largest rotation between two frames");
  OPTION(bool, differential_drive, false,
         "the robot heads where it drives and its forward camera does not sway; false: the camera "
         "looks into corners and rooms, as one in a hand");
  REGISTER_OPTIONS();
};

struct QueryOptions {
  OPTION(int, num_queries, 60, {0, 100000}, "pictures from beside the route");
  OPTION(double, min_offset_m, 0.2, {0, 2}, "smallest distance to the whole route");
  OPTION(double, max_offset_m, 0.6, {0, 3},
         "largest distance to the nearest of the route's frames");
  double max_heading_change_rad = 0.436;  // largest difference of heading from that frame
  double max_height_change_m = 0.1;       // largest difference of height from that frame
  double clearance_m = 0.3;               // smallest distance from a query to an obstacle
  OPTION(double, min_covisible_ratio, 0.5, {0, 1},
         "share of the query's view that frames near it on the route saw");
  REGISTER_OPTIONS();
};

struct FloorPlanOptions {
  double cell_m = 0.05;  // edge length of a cell of the true plan
  OPTION(double, min_height_m, 0.1, {0, 3}, "height above which obstacles count");
  OPTION(double, max_height_m, 1.5, {0, 5}, "height below which obstacles count");
  REGISTER_OPTIONS();
};

struct ScannerOptions {
  OPTION(double, rate_hz, 0, {0, 1000},
         "scans per second of the robot's laser; 0: the robot has neither laser nor odometry");
  OPTION(double, start_s, 0, {0, 10}, "time of the first scan after the first frame");
  OPTION(double, field_of_view_deg, 180, {1, 360},
         "angle that the beams of a scan share out, half of it to each side of the robot's x");
  OPTION(int, num_beams, 180, {1, 100000}, "beams per scan");
  OPTION(double, max_range_m, 30, {0.5, 1000},
         "farthest range measured, and the range of a beam that returns nothing");
  double height_m = 0.3;  // laser above the floor
  OPTION(double, duration_s, 0.0133, {0, 1},
         "time over which the beams of a scan are spread; the robot moves meanwhile");
  double noise_constant_m = 0.01;  // range noise at 0 m
  double noise_per_m = 0.002;      // sigma = noise_constant_m + noise_per_m * range
  double miss_ratio = 0.005;       // share of beams lost at random
  // Share of the stretches, 1 m long, of walls and doors that return nothing.
  double glass_ratio = 0.03;
  double black_ratio = 0.03;  // share of surfaces that are as black as those of a dark tint
  OPTION(double, black_range_m, 3, {0, 1000}, "range beyond which black surfaces return nothing");
  int num_walkers = 0;
  REGISTER_OPTIONS();
};

struct WheelOptions {
  double rate_hz = 20;  // samples of the odometry per second
  OPTION(double, scale_bias, 0.01, {-0.5, 0.5},
         "share by which the odometry's distances are too long");
  OPTION(double, heading_bias_rad_per_m, 0.002, {-1, 1},
         "turn to the left that the odometry makes up per metre driven");
  // Noise of the odometry's distance after 1 m driven; grows with the distance's root.
  double distance_noise_m = 0.01;
  // Noise of the odometry's heading after a turn of 1 rad; grows with the turn's root.
  double heading_noise_rad = 0.01;
  // Noise of the odometry's heading after 1 m driven; grows with the distance's root.
  double heading_noise_rad_per_root_m = 0;
  REGISTER_OPTIONS();
};

// A stretch of the drive on which the wheels slip.
struct WheelSlipOptions {
  double at_s = 0;        // time of the drive at which the wheels begin to slip
  double duration_s = 2;  // time for which the wheels slip
  double ratio = 0;  // share by which slipping wheels report more distance than the robot drives
};

}  // namespace nightmap
