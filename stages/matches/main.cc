// SPDX-License-Identifier: Apache-2.0
// matches: reads features (and, for loops, the vocabulary); writes verified pairs of frames. With
// the output `pairs` it matches the frames of the last features file to their neighbours; with the
// output `loops` it matches frames that look alike.
#include "stages/matches/matches.h"

#include "pipeline/base/stage_main.h"

namespace nightmap {
namespace {

void Summarize(const std::vector<FramePair>& pairs, nlohmann::json* report) {
  int num_accepted = 0;
  std::size_t num_inliers = 0;
  for (const FramePair& pair : pairs) {
    num_accepted += pair.status == PairStatus::kAccepted;
    if (pair.status == PairStatus::kAccepted) num_inliers += pair.inliers.size();
  }
  (*report)["num_pairs"] = pairs.size();
  (*report)["num_accepted"] = num_accepted;
  (*report)["mean_inliers"] =
      num_accepted == 0 ? 0.0 : static_cast<double>(num_inliers) / num_accepted;
}

void Run(const MatchesOptions& options, StageContext& context) {
  const bool wants_pairs = context.HasOutput("pairs");
  if (wants_pairs == context.HasOutput("loops")) {
    throw UsageError("give either --out pairs=PATH or --out loops=PATH");
  }
  if (!wants_pairs && !context.HasInput("vocabulary")) {
    throw UsageError("--out loops needs --in vocabulary=PATH");
  }
  const auto frames = ReadFrames(context.Inputs("frames"));
  const MatchesInput input{frames,
                           ReadCameras(context.Input("cameras"), frames),
                           ReadFeatures(context.Inputs("features"))};
  std::vector<FramePair> pairs;
  if (wants_pairs) {
    const int first_frame_idx = ReadFrames(context.Inputs("frames").back()).front().frame_idx;
    pairs = MatchNeighbours(
        options, input, first_frame_idx, context.NumThreads(), context.GetProgress());
  } else {
    const Vocabulary vocabulary = ReadVocabulary(context.Input("vocabulary"));
    pairs = MatchLoops(options, input, vocabulary, context.NumThreads(), context.GetProgress());
  }
  WritePairs(context.Output(wants_pairs ? "pairs" : "loops"), pairs, context.ConfigToml());
  Summarize(pairs, &context.Report());
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "matches",
      "Matches frames to their neighbours, or to frames that look alike, and verifies each pair.",
      {{"frames", "shard_NNNN.csv of the frames stage", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       {"features", "shard_NNNN.h5 of the same shards, in order", Arity::kMany},
       {"vocabulary", "vocabulary.h5, for loops", Arity::kOptional}},
      {{"pairs", "shard_NNNN.h5: pairs of the last shard given", Arity::kOptional},
       {"loops", "loops.h5: loop candidates over all shards given", Arity::kOptional}}};
  return StageMain(argc, argv, spec, MatchesOptions{}, Run);
}
