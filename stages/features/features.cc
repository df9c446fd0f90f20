// SPDX-License-Identifier: Apache-2.0
#include "stages/features/features.h"

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace nightmap {

FeaturesResult RunFeatures(const FeaturesOptions& options,
                           const std::vector<FrameRecord>& frames,
                           const std::vector<RgbdCamera>& cameras,
                           const RgbdLoader& load,
                           int num_threads,
                           Progress& progress) {
  FeaturesResult result;
  ExtractionOptions extraction = options.extraction;
  result.shard.extraction = RegisterOptions(extraction).ToToml();
  result.shard.kind = options.extraction.Kind();
  result.shard.descriptor_size = DescriptorSize(result.shard.kind);
  result.shard.frames.resize(frames.size());
  std::vector<std::string> failures(frames.size());
  progress.Start(frames.size());
  ParallelFor(frames.size(), num_threads, [&](std::size_t i) {
    FrameFeatures& features = result.shard.frames[i];
    try {
      const RgbdImages images = load(frames[i]);
      const Camera& camera = cameras.at(static_cast<std::size_t>(frames[i].camera_idx)).color;
      features = ExtractFeatures(images.color, camera, options.extraction);
      LookUpDepth(images.depth, options.extraction, &features);
    } catch (const DataError& error) {
      failures[i] = error.what();
    }
    features.frame_idx = frames[i].frame_idx;
    progress.Advance();
  });
  for (const std::string& failure : failures) {
    if (!failure.empty()) result.skipped.push_back(failure);
  }
  return result;
}

}  // namespace nightmap
