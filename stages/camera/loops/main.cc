// SPDX-License-Identifier: Apache-2.0
// loops: reads the features of all shards and the vocabulary; writes verified pairs of frames that
// look alike.
#include "stages/camera/loops/loops.h"

#include <utility>

#include "pipeline/program/stage_main.h"
#include "stages/camera/loops/loops_of_what_stays.h"

namespace nightmap {
namespace {

void Run(const LoopsOptions& options, StageContext& context) {
  if (context.HasInput("masked_frames") != context.HasInput("masks")) {
    throw UsageError("give both --in masked_frames=PATH and --in masks=PATH, or neither");
  }
  FramesWithFeatures input = ReadFramesWithFeatures(
      context.Inputs("frames"), context.Input("cameras"), context.Inputs("features"));
  Vocabulary vocabulary = ReadVocabulary(context.Input("vocabulary"));
  const auto pairs =
      context.HasInput("masked_frames")
          ? RunLoopsOfWhatStays(options,
                                std::move(input),
                                std::move(vocabulary),
                                ReadFrames(context.Inputs("masked_frames")),
                                FrameReader({}, context.Inputs("masks")),
                                context.GetProgress(),
                                context.NumThreads())
          : RunLoops(options, input, vocabulary, context.GetProgress(), context.NumThreads());
  WritePairs(context.Output("loops"), pairs, context.ConfigToml());
  context.Report() = PairsReport(pairs);
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"loops",
                       "Matches frames to those that look alike and verifies each pair.",
                       {{"frames", "shard_NNNN.csv of the frames stage", Arity::kMany},
                        {"cameras", "cameras.json of the frames stage"},
                        {"features", "shard_NNNN.h5 of the same shards, in order", Arity::kMany},
                        {"vocabulary", "vocabulary.h5 of the same features"},
                        {"masked_frames", "lists of frames with masks", Arity::kAnyNumber},
                        {"masks", "masks of what labels say may move", Arity::kAnyNumber}},
                       {{"loops", "loops.h5: loop candidates over all given shards"}}};
  return StageMain(argc, argv, spec, LoopsOptions{}, Run);
}
