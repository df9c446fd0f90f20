// SPDX-License-Identifier: Apache-2.0
// matches: reads the features of a shard and of the shard before it; writes verified pairs of
// frames near each other.
#include "pipeline/program/stage_main.h"
#include "stages/camera/matches/matches.h"

namespace nightmap {
namespace {

void Run(const MatchesOptions& options, StageContext& context) {
  const FramesWithFeatures input = ReadFramesWithFeatures(
      context.Inputs("frames"), context.Input("cameras"), context.Inputs("features"));
  const int first_frame_idx = ReadFrames(context.Inputs("frames").back()).front().frame_idx;
  const auto pairs =
      RunMatches(options, input, first_frame_idx, context.GetProgress(), context.NumThreads());
  WritePairs(context.Output("pairs"), pairs, context.ConfigToml());
  context.Report() = PairsReport(pairs);
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "matches",
      "Matches the frames of a shard to frames shortly before them and verifies each pair.",
      {{"frames",
        "shard_NNNN.csv of the frames stage; the last one is the shard itself",
        Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"features", "shard_NNNN.h5 of the same shards, in order", Arity::kMany}},
      {{"pairs", "shard_NNNN.h5: pairs of the last given shard"}}};
  return StageMain(argc, argv, spec, MatchesOptions{}, Run);
}
