// SPDX-License-Identifier: Apache-2.0
// vocabulary: reads the features of all mapping frames, writes vocabulary.h5 (tree, and words of
// the frames).
#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/vocabulary/vocabulary.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"vocabulary",
                       "trains the vocabulary tree and indexes every mapping frame by its words",
                       {{"features", "shards of the features stage, in order", Arity::kMany}},
                       {{"vocabulary", "vocabulary.h5: tree, and words of each frame"}}};
  return StageMain(
      argc, argv, spec, VocabularyOptions{}, [](const auto& options, StageContext& context) {
        const SiteFeatures features(context.Inputs("features"), {});
        context.BeginPart("train");
        const Vocabulary vocabulary =
            RunVocabulary(options, features, context.GetProgress(), context.NumThreads());
        context.BeginPart("write");
        WriteVocabulary(context.Output("vocabulary"), vocabulary, context.ConfigToml());
        std::size_t num_features = 0;
        for (const auto& words : vocabulary.words) num_features += words.size();
        context.Report()["num_frames"] = vocabulary.words.size();
        context.Report()["num_features"] = num_features;
        context.Report()["num_nodes"] = vocabulary.tree.NumNodes();
        context.Report()["num_words"] = NumWords(vocabulary.tree);
      });
}
