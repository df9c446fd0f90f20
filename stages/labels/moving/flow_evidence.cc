// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/flow_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

#include "pipeline/camera/follow_corners.h"
#include "stages/labels/moving/spread.h"

namespace nightmap {
namespace {

constexpr int kNumLevels = 2;       // as where it should be is known
constexpr int kHalfCell = 2;        // pixels of depth that a corner speaks for, on each side
constexpr double kEdgeStep = 0.05;  // relative
// A corner that moved looks different where it would be if it had not: by so much more than where
// it is followed to (gray levels).
constexpr double kMinRatio = 1.5;
constexpr double kMinWorse = 5;

// A corner that should be seen in the other frame.
struct Expected {
  std::vector<Eigen::Vector2f> corners;
  std::vector<Eigen::Vector2f> predicted;  // where it is if it stays
};

// Calls use(x, y) for the pixels of depth around a corner.
template <typename Use>
void ForCell(const DepthImage& depth, const Eigen::Vector2f& corner, const Use& use) {
  const int at_x = std::min(static_cast<int>(corner.x() / 2), depth.width - 1);
  const int at_y = std::min(static_cast<int>(corner.y() / 2), depth.height - 1);
  for (int y = std::max(at_y - kHalfCell, 0); y <= std::min(at_y + kHalfCell, depth.height - 1);
       ++y) {
    for (int x = std::max(at_x - kHalfCell, 0); x <= std::min(at_x + kHalfCell, depth.width - 1);
         ++x) {
      use(x, y);
    }
  }
}

// There the background is followed as well as the thing before it.
bool IsAtEdge(const SmallFrame& frame, const Eigen::Vector2f& corner) {
  const float depth_m = DepthAt(frame, corner);
  bool is_at_edge = false;
  ForCell(frame.depth, corner, [&](int x, int y) {
    is_at_edge |= frame.depth.At(x, y) <= 0 || Bond(depth_m, frame.depth.At(x, y), kEdgeStep) < 1;
  });
  return is_at_edge;
}

// Mean absolute difference of two patches, gray levels.
double PatchDifference(const GrayImage& a,
                       const Eigen::Vector2f& at_a,
                       const GrayImage& b,
                       const Eigen::Vector2f& at_b) {
  constexpr int kHalfPatch = 4;
  const cv::Point from(cvRound(at_a.x()), cvRound(at_a.y()));
  const cv::Point to(cvRound(at_b.x()), cvRound(at_b.y()));
  const cv::Rect in_a(0, 0, a.width, a.height);
  const cv::Rect in_b(0, 0, b.width, b.height);
  double sum = 0;
  int count = 0;
  for (int y = -kHalfPatch; y <= kHalfPatch; ++y) {
    for (int x = -kHalfPatch; x <= kHalfPatch; ++x) {
      const cv::Point off(x, y);
      if (!in_a.contains(from + off) || !in_b.contains(to + off)) continue;
      sum += std::abs(a.At(from.x + x, from.y + y) - b.At(to.x + x, to.y + y));
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

Expected Expect(const EvidenceOptions& options,
                const SmallCamera& camera,
                const SmallFrame& frame,
                const SmallFrame& other,
                const Rigid3& other_from_frame) {
  Expected expected;
  for (const Eigen::Vector2f& corner : frame.corners) {
    const double depth_m = DepthAt(frame, corner);
    if (depth_m <= 0 || IsAtEdge(frame, corner)) continue;
    const Eigen::Vector3d point =
        other_from_frame * camera.gray.BackProject(corner.cast<double>(), depth_m);
    const auto seen = camera.gray.Project(point);
    if (!seen || !camera.gray.Contains(*seen)) continue;
    const Eigen::Vector2f at = seen->cast<float>();
    const double there_m = DepthAt(other, at);
    const bool is_hidden =
        there_m > 0 && there_m < point.z() - Margin_m(options, camera, point.z());
    if (is_hidden) continue;
    expected.corners.push_back(corner);
    expected.predicted.push_back(at);
  }
  return expected;
}

}  // namespace

void AddFlowEvidence(const EvidenceOptions& options,
                     int window_px,
                     const SmallCamera& camera,
                     const SmallFrame& frame,
                     const SmallFrame& other,
                     const Rigid3& other_from_frame,
                     Evidence* evidence) {
  const auto [corners, predicted] = Expect(options, camera, frame, other, other_from_frame);
  if (corners.empty()) return;
  const Followed followed =
      Follow(frame.pyramid, other.pyramid, corners, {window_px, kNumLevels}, predicted);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double difference = followed.differences[i];
    if (!followed.is_found[i] || difference > options.max_patch_difference) continue;
    const bool stays = Distance_px(followed.points[i], predicted[i]) <= options.max_flow_px;
    if (!stays && PatchDifference(frame.gray, corners[i], other.gray, predicted[i]) <
                      kMinRatio * difference + kMinWorse) {
      continue;
    }
    Image<float>& votes = stays ? evidence->stays : evidence->gone;
    ForCell(frame.depth, corners[i], [&](int x, int y) { votes.At(x, y) += 1; });
  }
}

}  // namespace nightmap
