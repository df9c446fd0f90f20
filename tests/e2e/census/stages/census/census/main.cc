// SPDX-License-Identifier: Apache-2.0
// census: reads the frames and keyframes.tum, and writes census.json.
#include "pipeline/io/frames_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/census/census/census.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"census",
                       "counts frames and keyframes",
                       {{"frames", "shard_NNNN.csv of the frames stage", Arity::kMany},
                        {"keyframes", "keyframes.tum of the map_frame stage"}},
                       {{"census", "census.json: num_frames, num_keyframes"}}};
  return StageMain(
      argc, argv, spec, CensusOptions{}, [](const CensusOptions& options, StageContext& context) {
        const auto census = RunCensus(options,
                                      ReadFrames(context.Inputs("frames")).size(),
                                      ReadTum(context.Input("keyframes")).size());
        WriteFile(context.Output("census"), census.dump(2) + "\n");
        context.Report().update(census);
      });
}
