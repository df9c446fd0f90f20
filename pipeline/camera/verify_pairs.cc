// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/verify_pairs.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

// A frame of a pair and the camera that took it.
struct FrameView {
  SiteFeatures::Frame features;
  const RgbdCamera& camera;
};

FrameView View(const FramesWithFeatures& input, int frame_idx) {
  const auto i = static_cast<std::size_t>(frame_idx - input.frames.front().frame_idx);
  const auto camera_idx = static_cast<std::size_t>(input.frames[i].camera_idx);
  return {input.features.GetFrame(frame_idx), input.cameras.at(camera_idx)};
}

void VerifyOne(const VerifyOptions& options,
               const QuickCheck* quick,
               const FramesWithFeatures& input,
               FramePair* pair) {
  const FrameView a = View(input, pair->frame_a);
  const FrameView b = View(input, pair->frame_b);
  if (quick != nullptr) {
    const auto matches = quick->match(*a.features, *b.features);
    VerifyMatches(quick->verify, matches, *a.features, a.camera, *b.features, b.camera, pair);
    if (pair->status != PairStatus::kAccepted) return;
  }
  VerifyPair(options, *a.features, a.camera, *b.features, b.camera, pair);
}

}  // namespace

FramesWithFeatures ReadFramesWithFeatures(const std::vector<std::filesystem::path>& frames,
                                          const std::filesystem::path& cameras,
                                          const std::vector<std::filesystem::path>& features) {
  const auto records = ReadFrames(frames);
  return {records, ReadCameras(cameras, records), SiteFeatures(features, frames)};
}

FramePair MakePair(int frame_a, int frame_b) {
  FramePair pair;
  pair.frame_a = frame_a;
  pair.frame_b = frame_b;
  return pair;
}

void SortPairs(std::vector<FramePair>* pairs) {
  std::ranges::sort(
      *pairs, {}, [](const FramePair& pair) { return std::pair(pair.frame_b, pair.frame_a); });
}

void VerifyPairs(VerifyOptions options,
                 const QuickCheck* quick,
                 const FramesWithFeatures& input,
                 int num_threads,
                 Progress& progress,
                 std::vector<FramePair>* pairs) {
  options.kind = input.features.Heads().kind;
  progress.Start(pairs->size());
  ParallelFor(pairs->size(), num_threads, [&](std::size_t i) {
    FramePair& pair = (*pairs)[i];
    VerifyOne(options, quick, input, &pair);
    progress.Advance();
  });
}

nlohmann::json PairsReport(const std::vector<FramePair>& pairs) {
  int num_accepted = 0;
  std::size_t num_inliers = 0;
  for (const FramePair& pair : pairs) {
    num_accepted += pair.status == PairStatus::kAccepted;
    if (pair.status == PairStatus::kAccepted) num_inliers += pair.inliers.size();
  }
  const double mean_inliers =
      num_accepted == 0 ? 0.0 : static_cast<double>(num_inliers) / num_accepted;
  return {
      {"num_pairs", pairs.size()}, {"num_accepted", num_accepted}, {"mean_inliers", mean_inliers}};
}

}  // namespace nightmap
