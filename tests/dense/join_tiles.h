// SPDX-License-Identifier: Apache-2.0
// Tiles that programs join, and a run of such a program.
#pragma once

#include <string>
#include <vector>

#include "pipeline/dense/tiles_io.h"
#include "pipeline/program/stage_main.h"
#include "tests/test_data.h"

namespace nightmap {

// Keyframe k is of the time k.
inline Tile TileOf(const MapRegion& region, int num_keyframes) {
  Tile tile;
  tile.region = region;
  for (int k = 0; k < num_keyframes; ++k) {
    Keyframe& keyframe = tile.keyframes.emplace_back();
    keyframe.keyframe_idx = k;
    keyframe.frame.color = {"c.png", "c"};
    keyframe.frame.depth = {"d.png", "d"};
    keyframe.frame.time_ns = k;
  }
  return tile;
}

// Returns the exit code; `log` gets what the program says.
template <typename Options, typename Body>
int RunProgram(const StageSpec& spec,
               std::vector<std::string> arguments,
               const Options& options,
               const Body& body,
               std::string* log) {
  arguments.insert(arguments.begin(), spec.name);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  testing::internal::CaptureStderr();
  const int code = StageMain(static_cast<int>(argv.size()), argv.data(), spec, options, body);
  *log = testing::internal::GetCapturedStderr();
  return code;
}

}  // namespace nightmap
