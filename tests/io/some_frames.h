// SPDX-License-Identifier: Apache-2.0
// Frames and cameras of 40 x 30 pixels for tests.
#pragma once

#include "pipeline/io/frames_io.h"

namespace nightmap {

inline std::vector<FrameRecord> SomeFrames(int first_idx, int count) {
  std::vector<FrameRecord> frames;
  for (int i = first_idx; i < first_idx + count; ++i) {
    frames.push_back({.frame_idx = i,
                      .time_ns = 1305031102175304000 + i,
                      .camera_idx = i % 3,
                      .sequence_idx = i / 10,
                      .color = {"site/a, \"b\" " + std::to_string(i) + ".png", "0123456789abcdef"},
                      .depth = i % 2 ? ChannelFile{} : ChannelFile{"site/depth.png", "ab"},
                      .others = {}});
  }
  return frames;
}

inline RgbdCamera SomeCamera() {
  RgbdCamera camera;
  camera.camera_id = "color";
  camera.color = {.width = 40,
                  .height = 30,
                  .fx = 35.25,
                  .fy = 36.1,
                  .cx = 19.5,
                  .cy = 14.5,
                  .k1 = 0.1,
                  .k2 = -0.2,
                  .p1 = 0.001,
                  .p2 = -0.002,
                  .k3 = 0.05};
  camera.depth_units_per_m = 5000;
  camera.min_depth_m = 0.3;
  camera.max_depth_m = 4.5;
  camera.noise = {.constant_m = 0.001, .quadratic_per_m = 0.003};
  return camera;
}

// Depth camera with other intrinsics and pose than the color camera; no distortion.
inline RgbdCamera UnregisteredCamera() {
  RgbdCamera camera = SomeCamera();
  camera.color = {.width = 80, .height = 60, .fx = 70, .fy = 70, .cx = 39.5, .cy = 29.5};
  camera.depth = {.width = 40, .height = 30, .fx = 35, .fy = 35, .cx = 19.5, .cy = 14.5};
  camera.depth_registered = false;
  return camera;
}

inline RgbdCamera MaskedCamera() {
  RgbdCamera camera = SomeCamera();
  GrayImage mask{40, 30, 1, std::vector<std::uint8_t>(1200, 0)};
  std::fill(mask.pixels.begin() + 1000, mask.pixels.end(), std::uint8_t{255});
  mask.At(3, 2) = 255;
  camera.mask = std::make_shared<GrayImage>(mask);
  return camera;
}

// A camera whose pictures have 80 x 60 pixels, seen as 40 x 30.
inline RgbdCamera ReducedCamera() {
  RgbdCamera camera = SomeCamera();
  camera.color = {.width = 80, .height = 60, .fx = 70, .fy = 70, .cx = 41, .cy = 29};
  ReduceToWorkingSize(1200e-6, &camera);
  return camera;
}

}  // namespace nightmap
