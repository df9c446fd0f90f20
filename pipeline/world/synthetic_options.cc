// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

namespace {

Camera CenteredPinhole(int width_px, int height_px, double focal_length_px) {
  Camera camera;
  camera.width = width_px;
  camera.height = height_px;
  camera.fx = camera.fy = focal_length_px;
  camera.cx = 0.5 * (width_px - 1);
  camera.cy = 0.5 * (height_px - 1);
  return camera;
}

}  // namespace

void BuildingOptions::Register(OptionList& list) {
  list.Add(
      "seed", &seed, Range(0, 2e9), "seed of everything random in the building and its recording");
  list.Add("num_rooms", &num_rooms, Range(1, 300), "rooms around and inside the corridor loop");
  list.Add("num_identical_rooms",
           &num_identical_rooms,
           Range(0, 300),
           "rooms that share one furnishing and one set of pictures (perceptual aliasing)");
  list.Add(
      "room_width_m", &room_width_m, Range(2.8, 12), "inner width of a room, along the corridor");
  list.Add("room_depth_m", &room_depth_m, Range(2.6, 12), "inner depth of a room");
  list.Add("corridor_width_m", &corridor_width_m, Range(1.3, 5), "inner width of the corridor");
  list.Add("wall_thickness_m", &wall_thickness_m, Range(0.05, 0.5), "thickness of every wall");
  list.Add("ceiling_height_m", &ceiling_height_m, Range(2.3, 5), "height from floor to ceiling");
  list.Add("door_width_m", &door_width_m, Range(0.8, 1.2), "clear width of a doorway");
  list.Add("repeated_panel_ratio",
           &repeated_panel_ratio,
           Range(0, 1),
           "share of the corridor's pictures that are the same notice board");
  list.Add(
      "mirrored_corridors",
      &mirrored_corridors,
      "furnishes opposite corridors alike, so that the building looks the same after a half turn");
  list.Add(
      "blank_walls_length_m",
      &blank_walls_length_m,
      Range(0, 12),
      "length of the stretch in the middle of the east corridor where walls and floor are of one "
      "color; at most room_depth_m");
  list.Add("ceiling_fittings_per_m2",
           &ceiling_fittings_per_m2,
           Range(0, 4),
           "vents, hatches, smoke detectors, sprinklers and tiles of another tone in the ceilings");
  list.Add("num_floors",
           &num_floors,
           Range(1, 2),
           "storeys of the same layout, furnished differently; a ramp west of them joins two");
  list.Add("slab_thickness_m",
           &slab_thickness_m,
           Range(0.1, 1),
           "distance from a ceiling to the floor above it");
  list.Add("ramp_slope", &ramp_slope, Range(0.05, 0.5), "rise of the ramp over its run");
  list.Add("light_map_cell_m", &light_map_cell_m, Range(0.02, 1), "spacing of baked light samples");
  list.Add("num_light_samples", &num_light_samples, Range(1, 1024), "rays per baked light sample");
}

void SyntheticCameraOptions::Register(OptionList& list) {
  list.Add("image_width_px", &image_width_px, Range(32, 4096), "width of color, depth and labels");
  list.Add(
      "image_height_px", &image_height_px, Range(32, 4096), "height of color, depth and labels");
  list.Add("focal_length_px", &focal_length_px, Range(10, 10000), "fx = fy of color and depth");
  list.Add("camera_height_m", &camera_height_m, Range(0.2, 2), "camera above the floor");
  list.Add("pitch_rad", &pitch_rad, Range(-0.8, 0.8), "downward tilt of the camera");
  list.Add("color_noise_levels",
           &color_noise_levels,
           Range(0, 30),
           "standard deviation of the color noise, in 8-bit levels");
}

Camera SyntheticCameraOptions::Pinhole() const {
  return CenteredPinhole(image_width_px, image_height_px, focal_length_px);
}

void UpwardMountOptions::Register(OptionList& list, const std::string& prefix) {
  list.Add(
      prefix + "camera_height_m", &camera_height_m, Range(0.05, 1.9), "camera above the floor");
  list.Add(prefix + "mount_tilt_rad",
           &mount_tilt_rad,
           Range(0, 0.2),
           "sigma of the roll and pitch by which the camera is mounted");
  list.Add(prefix + "vibration_rad",
           &vibration_rad,
           Range(0, 0.05),
           "sigma of the roll and pitch by which the camera shakes; correlated over 0.05 s");
}

void UpwardCameraOptions::Register(OptionList& list) {
  list.Add("upward_rate_hz",
           &rate_hz,
           Range(0, 1000),
           "pictures per second of the robot's camera that looks straight up; 0: it has none");
  list.Add("upward_image_width_px", &image_width_px, Range(16, 8192), "columns of its pictures");
  list.Add("upward_image_height_px", &image_height_px, Range(16, 8192), "rows of its pictures");
  list.Add("upward_focal_length_px", &focal_length_px, Range(4, 1e5), "its focal length, fx = fy");
  mount.Register(list, "upward_");
}

Camera UpwardCameraOptions::Pinhole() const {
  return CenteredPinhole(image_width_px, image_height_px, focal_length_px);
}

void DepthSensorOptions::Register(OptionList& list) {
  list.Add("min_depth_m", &min_depth_m, Range(0, 5), "nearest depth measured");
  list.Add("max_depth_m", &max_depth_m, Range(0.5, 13), "farthest depth measured");
  list.Add("noise_constant_m", &noise_constant_m, Range(0, 0.1), "depth noise at 0.4 m");
  list.Add("noise_quadratic_per_m",
           &noise_quadratic_per_m,
           Range(0, 0.1),
           "sigma = noise_constant_m + noise_quadratic_per_m (z - 0.4 m)^2");
  list.Add("baseline_m",
           &baseline_m,
           Range(0.01, 1),
           "distance from projector to sensor, for the quantization");
  list.Add("disparity_step_px", &disparity_step_px, Range(0, 2), "disparity quantum; 0: none");
  list.Add("max_incidence_rad",
           &max_incidence_rad,
           Range(0.1, 1.5708),
           "surfaces seen at a more grazing angle give no depth");
  list.Add(
      "edge_hole_ratio", &edge_hole_ratio, Range(0, 1), "share of depth-edge pixels that are lost");
  list.Add(
      "dropout_ratio", &dropout_ratio, Range(0, 1), "share of all pixels that are lost at random");
}

void RouteOptions::Register(OptionList& list) {
  list.Add("num_frames", &num_frames, Range(2, 1e6), "frames of the recording");
  list.Add("num_laps", &num_laps, Range(1, 20), "number of times the robot goes through all rooms");
  list.Add("clearance_m",
           &clearance_m,
           Range(0.2, 0.45),
           "smallest distance from the route to an obstacle");
  list.Add("start_ratio",
           &start_ratio,
           Range(0, 1),
           "position on the route where the recording begins, as a share of the route");
  list.Add("length_ratio", &length_ratio, Range(0.01, 1), "share of the route that is recorded");
  list.Add("overlap_m", &overlap_m, Range(0, 20), "distance driven beyond length_ratio");
  list.Add("corner_radius_m", &corner_radius_m, Range(0.05, 1), "smoothing radius of the corners");
  list.Add("max_step_m", &max_step_m, Range(0.001, 1), "largest motion between two frames");
  list.Add("max_turn_rad", &max_turn_rad, Range(0.001, 1), "largest rotation between two frames");
  list.Add(
      "differential_drive",
      &differential_drive,
      "the robot heads where it drives and its forward camera does not sway; false: the camera "
      "looks into corners and rooms, as one in a hand");
}

void QueryOptions::Register(OptionList& list) {
  list.Add("num_queries", &num_queries, Range(0, 100000), "pictures from beside the route");
  list.Add("min_offset_m", &min_offset_m, Range(0, 2), "smallest distance to the whole route");
  list.Add("max_offset_m",
           &max_offset_m,
           Range(0, 3),
           "largest distance to the nearest of the route's frames");
  list.Add("max_heading_change_rad",
           &max_heading_change_rad,
           Range(0, 3.2),
           "largest difference of heading from that frame");
  list.Add("max_height_change_m",
           &max_height_change_m,
           Range(0, 0.5),
           "largest difference of height from that frame");
  list.Add("query_clearance_m",
           &clearance_m,
           Range(0.05, 1),
           "smallest distance from a query to an obstacle");
  list.Add("min_covisible_ratio",
           &min_covisible_ratio,
           Range(0, 1),
           "share of the query's view that frames near it on the route saw");
}

void FloorPlanOptions::Register(OptionList& list) {
  list.Add("floor_plan_cell_m", &cell_m, Range(0.005, 1), "edge length of a cell of the true plan");
  list.Add(
      "floor_plan_min_height_m", &min_height_m, Range(0, 3), "height above which obstacles count");
  list.Add(
      "floor_plan_max_height_m", &max_height_m, Range(0, 5), "height below which obstacles count");
}

void ScannerOptions::Register(OptionList& list) {
  list.Add("scan_rate_hz",
           &rate_hz,
           Range(0, 1000),
           "scans per second of the robot's laser; 0: the robot has neither laser nor odometry");
  list.Add("scan_start_s", &start_s, Range(0, 10), "time of the first scan after the first frame");
  list.Add("scan_field_of_view_deg",
           &field_of_view_deg,
           Range(1, 360),
           "angle that the beams of a scan share out, half of it to each side of the robot's x");
  list.Add("scan_num_beams", &num_beams, Range(1, 100000), "beams per scan");
  list.Add("scan_max_range_m",
           &max_range_m,
           Range(0.5, 1000),
           "farthest range measured, and the range of a beam that returns nothing");
  list.Add("scan_height_m", &height_m, Range(0.02, 2), "laser above the floor");
  list.Add("scan_duration_s",
           &duration_s,
           Range(0, 1),
           "time over which the beams of a scan are spread; the robot moves meanwhile");
  list.Add("scan_noise_constant_m", &noise_constant_m, Range(0, 1), "range noise at 0 m");
  list.Add("scan_noise_per_m",
           &noise_per_m,
           Range(0, 0.1),
           "sigma = scan_noise_constant_m + scan_noise_per_m * range");
  list.Add("scan_miss_ratio", &miss_ratio, Range(0, 1), "share of beams lost at random");
  list.Add("scan_glass_ratio",
           &glass_ratio,
           Range(0, 1),
           "share of the stretches, 1 m long, of walls and doors that return nothing");
  list.Add("scan_black_ratio",
           &black_ratio,
           Range(0, 1),
           "share of surfaces that are as black as those of a dark tint");
  list.Add("scan_black_range_m",
           &black_range_m,
           Range(0, 1000),
           "range beyond which black surfaces return nothing");
  list.Add("num_walkers",
           &num_walkers,
           Range(0, 1000),
           "people who walk back and forth near the robot's route; the laser sees their legs, "
           "pictures do not show them");
}

void WheelOptions::Register(OptionList& list) {
  list.Add("wheel_rate_hz", &rate_hz, Range(0.1, 10000), "samples of the odometry per second");
  list.Add("wheel_scale_bias",
           &scale_bias,
           Range(-0.5, 0.5),
           "share by which the odometry's distances are too long");
  list.Add("wheel_heading_bias_rad_per_m",
           &heading_bias_rad_per_m,
           Range(-1, 1),
           "turn to the left that the odometry makes up per metre driven");
  list.Add("wheel_distance_noise_m",
           &distance_noise_m,
           Range(0, 1),
           "noise of the odometry's distance after 1 m driven; grows with the distance's root");
  list.Add("wheel_heading_noise_rad",
           &heading_noise_rad,
           Range(0, 1),
           "noise of the odometry's heading after a turn of 1 rad; grows with the turn's root");
  list.Add("wheel_heading_noise_rad_per_root_m",
           &heading_noise_rad_per_root_m,
           Range(0, 1),
           "noise of the odometry's heading after 1 m driven; grows with the distance's root");
}

void WheelSlipOptions::Register(OptionList& list) {
  list.Add(
      "slip_at_s", &at_s, Range(0, 1e5), "time of the drive at which the wheels begin to slip");
  list.Add("slip_duration_s", &duration_s, Range(0, 1e5), "time for which the wheels slip");
  list.Add("slip_ratio",
           &ratio,
           Range(-1, 10),
           "share by which slipping wheels report more distance than the robot drives");
}

}  // namespace nightmap
