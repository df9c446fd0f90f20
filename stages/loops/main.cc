// SPDX-License-Identifier: Apache-2.0
// loops: reads the features of all shards and the vocabulary; writes verified pairs of frames that
// look alike.
#include "stages/loops/loops.h"

#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const LoopsOptions& options, StageContext& context) {
  const FramesWithFeatures input = ReadFramesWithFeatures(
      context.Inputs("frames"), context.Input("cameras"), context.Inputs("features"));
  const Vocabulary vocabulary = ReadVocabulary(context.Input("vocabulary"));
  const auto pairs =
      RunLoops(options, input, vocabulary, context.NumThreads(), context.GetProgress());
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
                        {"vocabulary", "vocabulary.h5 of the same features"}},
                       {{"loops", "loops.h5: loop candidates over all given shards"}}};
  return StageMain(argc, argv, spec, LoopsOptions{}, Run);
}
