// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_noise.h"

namespace nightmap {

void CeilingNoise::Register(OptionList& list) {
  list.Add("pixel_sigma_px", &pixel_sigma_px, Range(0.01, 10), "noise of a corner in a picture");
  list.Add("distance_sigma_m",
           &distance_sigma_m,
           Range(1e-4, 1),
           "noise of the wheels' distance after 1 m; grows with the distance's root");
  list.Add("heading_sigma_rad",
           &heading_sigma_rad,
           Range(1e-5, 1),
           "noise of the wheels' heading after 1 m; grows with the distance's root");
  list.Add("turn_sigma_rad",
           &turn_sigma_rad,
           Range(1e-5, 1),
           "noise of the wheels' heading after a turn of 1 rad; grows with the turn's root");
  list.Add("scale_sigma",
           &scale_sigma,
           Range(0, 0.5),
           "share by which all distances of the wheels may be wrong; no picture tells it, so the "
           "map's size is as wrong as the wheels are");
  list.Add("heading_bias_sigma_rad_per_m",
           &heading_bias_sigma_rad_per_m,
           Range(0, 1),
           "turn that the wheels may make up per metre all the time");
  list.Add("mounting_tilt_sigma_rad",
           &mounting_tilt_sigma_rad,
           Range(0, 0.3),
           "tilt of the camera against robot_from_camera, about each of its axes");
  list.Add("vibration_sigma_rad",
           &vibration_sigma_rad,
           Range(0, 0.1),
           "tilt of the driving robot, from frame to frame");
  list.Add("unknown_speed_m_per_s",
           &unknown_speed_m_per_s,
           Range(0, 10),
           "speed of a robot whose wheels say nothing");
  list.Add("unknown_turn_rad_per_s",
           &unknown_turn_rad_per_s,
           Range(0, 10),
           "turning speed of a robot whose wheels say nothing");
}

}  // namespace nightmap
