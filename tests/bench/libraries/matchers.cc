// SPDX-License-Identifier: Apache-2.0
// MatchDescriptors against OpenCV's matchers. Both take the same pairs of frames, one pair per
// thread, and give mutual nearest neighbours that pass the ratio test.
#include <fmt/format.h>

#include <opencv2/features2d.hpp>
#include <set>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/extract_features.h"
#include "pipeline/camera/match_descriptors.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"

namespace nightmap {
namespace {

constexpr double kMaxRatio = 0.85;
constexpr std::size_t kNumPairs = 24;

using Matches = std::vector<std::vector<FeatureMatch>>;  // of each pair

struct FeaturePairs {
  DescriptorKind kind;
  std::vector<std::pair<FrameFeatures, FrameFeatures>> features;
  std::vector<std::pair<cv::Mat, cv::Mat>> matrices;  // the same, of the type that OpenCV wants
};

cv::Mat ToMatrix(const FrameFeatures& features, DescriptorKind kind) {
  const cv::Mat bytes(features.NumFeatures(),
                      DescriptorSize(kind),
                      CV_8U,
                      const_cast<std::uint8_t*>(features.descriptors.data()));
  cv::Mat matrix;
  bytes.convertTo(matrix, kind == DescriptorKind::kRootSift ? CV_32F : CV_8U);
  return matrix;
}

void AddPair(FrameFeatures a, FrameFeatures b, FeaturePairs* pairs) {
  pairs->matrices.emplace_back(ToMatrix(a, pairs->kind), ToMatrix(b, pairs->kind));
  pairs->features.emplace_back(std::move(a), std::move(b));
}

FeaturePairs SiftPairs(const MappedSite& site) {
  FeaturePairs pairs{DescriptorKind::kRootSift, {}, {}};
  for (const FramePair& pair : EvenlySpaced(site.loops, kNumPairs)) {
    AddPair(site.FeaturesOf(pair.frame_a), site.FeaturesOf(pair.frame_b), &pairs);
  }
  return pairs;
}

FeaturePairs OrbPairs(const MappedSite& site) {
  ExtractionOptions options;
  options.detector = "orb";
  const auto extract = [&](int frame_idx) {
    const FrameRecord& frame = site.frames[static_cast<std::size_t>(frame_idx)];
    const RgbdCamera& camera = site.CameraOf(frame_idx);
    return ExtractFeatures(LoadColor(frame, camera, site.data), camera.color, options);
  };
  FeaturePairs pairs{DescriptorKind::kOrb, {}, {}};
  for (const FramePair& pair : EvenlySpaced(site.loops, kNumPairs)) {
    AddPair(extract(pair.frame_a), extract(pair.frame_b), &pairs);
  }
  return pairs;
}

std::vector<FeatureMatch> MutualMatches(cv::DescriptorMatcher& matcher,
                                        const cv::Mat& a,
                                        const cv::Mat& b) {
  std::vector<std::vector<cv::DMatch>> forward;
  std::vector<std::vector<cv::DMatch>> backward;
  matcher.knnMatch(a, b, forward, 2);
  matcher.knnMatch(b, a, backward, 1);
  std::vector<FeatureMatch> matches;
  for (const auto& nearest : forward) {
    if (nearest.size() < 2) continue;  // LSH may find none
    const cv::DMatch& best = nearest[0];
    const auto& back = backward[static_cast<std::size_t>(best.trainIdx)];
    const bool is_mutual = !back.empty() && back[0].trainIdx == best.queryIdx;
    if (is_mutual &&
        static_cast<double>(best.distance) < kMaxRatio * static_cast<double>(nearest[1].distance)) {
      matches.push_back({best.queryIdx, best.trainIdx});
    }
  }
  return matches;
}

std::string Agreement(const Matches& ours, const Matches& other) {
  std::size_t num_ours = 0;
  std::size_t num_other = 0;
  std::size_t num_both = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    std::set<std::pair<int, int>> of_ours;
    for (const FeatureMatch& match : ours[i]) of_ours.emplace(match.a, match.b);
    for (const FeatureMatch& match : other[i]) num_both += of_ours.contains({match.a, match.b});
    num_ours += ours[i].size();
    num_other += other[i].size();
  }
  return fmt::format("{} and {} matches, {} the same", num_ours, num_other, num_both);
}

using MakeMatcher = std::function<cv::Ptr<cv::DescriptorMatcher>()>;

void Compare(const FeaturePairs& pairs,
             const std::string& other,
             const std::string& input,
             const MakeMatcher& make) {
  const std::size_t count = pairs.features.size();
  Matches ours(count);
  Matches theirs(count);
  PrintComparison({.ours = "`MatchDescriptors`",
                   .other = other,
                   .input = input,
                   .run_ours =
                       [&](int num_threads) {
                         ParallelFor(count, num_threads, [&](std::size_t i) {
                           const auto& [a, b] = pairs.features[i];
                           ours[i] = MatchDescriptors(a, b, pairs.kind, kMaxRatio);
                         });
                       },
                   .run_other =
                       [&](int num_threads) {
                         cv::setNumThreads(1);
                         ParallelFor(count, num_threads, [&](std::size_t i) {
                           const auto& [a, b] = pairs.matrices[i];
                           theirs[i] = MutualMatches(*make(), a, b);
                         });
                       },
                   .difference = [&] { return Agreement(ours, theirs); },
                   .num_items = static_cast<double>(count)});
}

}  // namespace

void CompareMatchers(const MappedSite& site) {
  const FeaturePairs sift = SiftPairs(site);
  const std::string input = fmt::format("{}: pair of frames, ", site.name);
  Compare(sift, "`cv::BFMatcher`", input + "RootSIFT", [] {
    return cv::makePtr<cv::BFMatcher>(cv::NORM_L2);
  });
  Compare(sift, "`cv::FlannBasedMatcher`, 4 trees, 32 checks", input + "RootSIFT", [] {
    return cv::makePtr<cv::FlannBasedMatcher>();
  });
  const FeaturePairs orb = OrbPairs(site);
  Compare(orb, "`cv::BFMatcher`", input + "ORB", [] {
    return cv::makePtr<cv::BFMatcher>(cv::NORM_HAMMING);
  });
  Compare(orb, "`cv::FlannBasedMatcher`, LSH 12, 20, 2", input + "ORB", [] {
    return cv::makePtr<cv::FlannBasedMatcher>(cv::makePtr<cv::flann::LshIndexParams>(12, 20, 2));
  });
}

}  // namespace nightmap
