// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

namespace nightmap {

WheelOptions SynthesizeCeilingOptions::CeilingWheels() {
  WheelOptions wheels;
  wheels.scale_bias = 0;
  wheels.heading_bias_rad_per_m = 0;
  wheels.distance_noise_m = 0.02;
  wheels.heading_noise_rad_per_root_m = 0.0175;
  return wheels;
}

void SynthesizeCeilingOptions::Register(OptionList& list) {
  list.Add("seed", &seed, Range(0, 1e9), "decides the building");
  list.Add("noise_seed",
           &noise_seed,
           Range(0, 1e9),
           "decides all but the building: tilt, vibration, light, noise; 0: the same as seed");
  list.Add("layout", &layout, {"corridor", "office"}, "a loop of corridors; six rooms");
  list.Add("blank_length_m",
           &blank_length_m,
           Range(0, 12),
           "corridor: length of the stretch where neither ceiling nor walls show anything");
  list.Add("overlap_m",
           &overlap_m,
           Range(6, 30),
           "corridor: way that the robot drives on after one loop, before it turns back for 5 m");
  list.Add("duration_s", &duration_s, Range(0, 1e5), "ends the recording early; 0: whole route");
  list.Add("image_width_px", &image_width_px, Range(16, 8192), "columns of a picture");
  list.Add("image_height_px", &image_height_px, Range(16, 8192), "rows of a picture");
  list.Add("focal_length_px", &focal_length_px, Range(4, 1e5), "focal length of the pinhole");
  list.Add("frame_rate_hz", &frame_rate_hz, Range(0.1, 1000), "pictures per second");
  list.Add("exposure_s", &exposure_s, Range(0, 0.5), "time over which motion blurs a picture");
  list.Add("color_noise_levels",
           &color_noise_levels,
           Range(0, 64),
           "sigma of the noise of each channel of a pixel, of 255");
  list.Add("vignetting", &vignetting, Range(0, 0.9), "share of the light that the corners lack");
  list.Add("light_change",
           &light_change,
           Range(0, 0.9),
           "share by which brightness rises and falls slowly");
  mount.Register(list);
  route.Register(list);
  wheels.Register(list);
  list.Add("wheel_scale_bias_sigma",
           &scale_bias_sigma,
           Range(0, 0.5),
           "sigma of what a draw by noise_seed adds to wheel_scale_bias");
  list.Add("wheel_heading_bias_sigma_rad_per_m",
           &heading_bias_sigma_rad_per_m,
           Range(0, 1),
           "sigma of what a draw by noise_seed adds to wheel_heading_bias_rad_per_m");
  slip.Register(list);
}

Camera SynthesizeCeilingOptions::Pinhole() const {
  Camera camera;
  camera.width = image_width_px;
  camera.height = image_height_px;
  camera.fx = camera.fy = focal_length_px;
  camera.cx = (image_width_px - 1) / 2.0;
  camera.cy = (image_height_px - 1) / 2.0;
  return camera;
}

std::uint64_t SynthesizeCeilingOptions::NoiseSeed() const {
  return static_cast<std::uint64_t>(noise_seed == 0 ? seed : noise_seed);
}

}  // namespace nightmap
