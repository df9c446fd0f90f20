// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/moving.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/follow_corners.h"
#include "pipeline/io/frame_failure.h"
#include "stages/labels/moving/flow_evidence.h"
#include "stages/labels/moving/region_motion.h"

namespace nightmap {
namespace {

// One shard's frames of one camera and sequence, in order of time, with the motion between them.
struct Chain {
  std::vector<std::size_t> frames;                        // indices of the input
  std::vector<std::optional<Rigid3>> next_from_previous;  // to the frame from the one before
};

// A frame's evidence and regions, which are kept until its mask is made.
struct Seen {
  Evidence evidence{{}};
  FrameRegions regions;
  Image<float> decided;  // of the pixels of regions; see SpreadEvidence
};

class Search {
 public:
  Search(const MovingOptions& options, const MovingInput& input)
      : options_(options),
        input_(input),
        offsets_s_(options.offsets_s),
        small_(input.frames.size()),
        seen_(input.frames.size()),
        masks_(input.frames.size()) {
    for (const RgbdCamera& camera : input.cameras) cameras_.push_back(Shrink(camera));
    std::ranges::sort(offsets_s_);
    std::map<std::pair<int, int>, Chain> chains;
    for (std::size_t i = 0; i < input.frames.size(); ++i) {
      chains[{input.frames[i].camera_idx, input.frames[i].sequence_idx}].frames.push_back(i);
    }
    for (auto& [key, chain] : chains) chains_.push_back(std::move(chain));
  }

  void Load(std::size_t i) {
    SmallFrame frame = Shrink(input_.load(input_.frames[i]), CameraOf(i));
    frame.corners = Corners(frame.gray, options_.camera_motion.cell_px);
    frame.pyramid = FlowPyramid(frame.gray, {options_.camera_motion.window_px});
    small_[i] = std::move(frame);
  }

  bool IsPublished() const { return options_.method == "published"; }

  void FindMotions(int num_threads) {
    for (Chain& chain : chains_) {
      chain.next_from_previous.resize(chain.frames.size());
      ParallelFor(chain.frames.size(), num_threads, [&](std::size_t k) {
        if (k > 0) chain.next_from_previous[k] = Motion(chain.frames[k - 1], chain.frames[k]);
      });
    }
  }

  const std::vector<Chain>& Chains() const { return chains_; }

  // Collects what other frames say of frame k of a chain.
  void Gather(const Chain& chain, std::size_t k) {
    const std::size_t i = chain.frames[k];
    if (!small_[i]) return;
    Seen& seen = seen_[i];
    seen.evidence = Evidence(small_[i]->depth);
    seen.regions.regions = FindLabelledRegions(small_[i]->may_move, small_[i]->depth);
    seen.regions.scores.resize(static_cast<std::size_t>(seen.regions.regions.num));
    if (IsPublished()) {
      const SmallFrame* previous = nullptr;
      if (k > 0 && small_[chain.frames[k - 1]]) previous = &*small_[chain.frames[k - 1]];
      seen.decided = PublishedDecision(options_.published,
                                       options_.camera_motion.window_px,
                                       CameraOf(i),
                                       previous,
                                       *small_[i],
                                       seen.regions.regions,
                                       SeedOf(i));
      MakeMask(i);
      return;
    }
    for (const bool forward : {false, true}) Look(chain, k, forward, &seen);
    if (seen.regions.regions.num == 0) MakeMask(i);
  }

  // Decides which regions of a chain's frames move, and masks the frames that have some.
  void Decide(const Chain& chain, int num_threads) {
    std::vector<const FrameRegions*> regions;
    for (const std::size_t i : chain.frames) regions.push_back(&seen_[i].regions);
    std::vector<std::vector<int>> same(chain.frames.size() - 1);
    ParallelFor(same.size(), num_threads, [&](std::size_t k) {
      const auto& motion = chain.next_from_previous[k + 1];
      const std::size_t i = chain.frames[k];
      if (!motion || regions[k]->regions.num == 0 || regions[k + 1]->regions.num == 0) return;
      same[k] = SameRegions(CameraOf(i), *small_[i], *regions[k], *regions[k + 1], *motion);
    });
    const auto moves = DecideRegions(regions, same);
    ParallelFor(chain.frames.size(), num_threads, [&](std::size_t k) {
      const std::size_t i = chain.frames[k];
      if (!small_[i] || regions[k]->regions.num == 0) return;
      seen_[i].decided = ZerosLike(small_[i]->depth);
      std::ranges::transform(regions[k]->regions.of_pixel.pixels,
                             seen_[i].decided.pixels.begin(),
                             [&](int region) -> float {
                               if (region == 0) return 0;
                               return moves[k][static_cast<std::size_t>(region - 1)] ? 1 : -1;
                             });
      MakeMask(i);
    });
  }

  // The mask of each frame; none of one that failed.
  std::vector<std::optional<PackedMask>> TakeMasks() { return std::move(masks_); }

 private:
  const SmallCamera& CameraOf(std::size_t i) const {
    return cameras_[static_cast<std::size_t>(input_.frames[i].camera_idx)];
  }

  std::uint64_t SeedOf(std::size_t i) const {
    return (static_cast<std::uint64_t>(options_.seed) << 32) ^
           static_cast<std::uint64_t>(input_.frames[i].frame_idx);
  }

  std::optional<Rigid3> Motion(std::size_t a, std::size_t b) const {
    if (!small_[a] || !small_[b]) return std::nullopt;
    return CameraMotion(options_.camera_motion, CameraOf(b), *small_[a], *small_[b], SeedOf(b));
  }

  // Adds what the frames after (or before) frame k say, the first at each of the offsets.
  void Look(const Chain& chain, std::size_t k, bool forward, Seen* seen) const {
    const std::size_t i = chain.frames[k];
    Rigid3 other_from_frame;
    auto offset_s = offsets_s_.begin();
    for (std::size_t m = k; offset_s != offsets_s_.end();) {
      if (forward ? m + 1 == chain.frames.size() : m == 0) return;
      const auto& motion = chain.next_from_previous[forward ? m + 1 : m];
      if (!motion) return;
      other_from_frame = (forward ? *motion : motion->Inverse()) * other_from_frame;
      m = forward ? m + 1 : m - 1;
      const std::size_t other = chain.frames[m];
      const double gap_s =
          1e-9 *
          std::abs(static_cast<double>(input_.frames[other].time_ns - input_.frames[i].time_ns));
      if (gap_s < *offset_s) continue;
      const SmallCamera& camera = CameraOf(i);
      const SmallFrame& frame = *small_[i];
      Evidence by_depth(frame.depth), by_flow(frame.depth);
      AddDepthEvidence(
          options_.evidence, camera, frame, *small_[other], other_from_frame, &by_depth);
      AddFlowEvidence(options_.evidence,
                      options_.camera_motion.window_px,
                      camera,
                      frame,
                      *small_[other],
                      other_from_frame,
                      &by_flow);
      int num_offsets = 0;
      for (; offset_s != offsets_s_.end() && gap_s >= *offset_s; ++offset_s) ++num_offsets;
      AddScores(
          options_.spread.stays_weight, by_depth, by_flow, forward, num_offsets, &seen->regions);
      seen->evidence += by_depth;
      seen->evidence += by_flow;
    }
  }

  // Makes the mask of a frame at the size of its picture, and forgets what was known.
  void MakeMask(std::size_t i) {
    const Seen seen = std::exchange(seen_[i], {});
    GrayImage moves{seen.evidence.gone.width, seen.evidence.gone.height, 1, {}};
    const auto spread =
        IsPublished()
            ? seen.decided
            : SpreadEvidence(options_.spread, seen.evidence, small_[i]->depth, seen.decided);
    for (std::size_t p = 0; p < spread.pixels.size(); ++p) {
      const float decided = seen.decided.pixels.empty() ? 0 : seen.decided.pixels[p];
      moves.pixels.push_back((decided != 0 ? decided : spread.pixels[p]) > 0 ? 255 : 0);
    }
    const RgbdCamera& camera =
        input_.cameras[static_cast<std::size_t>(input_.frames[i].camera_idx)];
    GrayImage mask = EnlargeDepthMask(moves, CameraOf(i), camera.color);
    cv::Mat view(mask.height, mask.width, CV_8UC1, mask.pixels.data());
    const int edge_px = 2 * options_.margin_px + 1;
    cv::dilate(view, view, cv::getStructuringElement(cv::MORPH_RECT, {edge_px, edge_px}));
    masks_[i] = PackMask(input_.frames[i].time_ns, mask);
  }

  const MovingOptions& options_;
  const MovingInput& input_;
  std::vector<double> offsets_s_;  // ascending
  std::vector<SmallCamera> cameras_;
  std::vector<std::optional<SmallFrame>> small_;  // none: the frame failed
  std::vector<Chain> chains_;
  std::vector<Seen> seen_;
  std::vector<std::optional<PackedMask>> masks_;
};

double Share(const std::optional<PackedMask>& mask) {
  if (!mask) return 0;
  return static_cast<double>(NumMasked(*mask)) / (static_cast<double>(mask->width) * mask->height);
}

}  // namespace

MovingResult RunMoving(const MovingOptions& options,
                       const MovingInput& input,
                       Progress& progress,
                       int num_threads) {
  MovingResult result;
  Search search(options, input);
  std::vector<std::string> failures(input.frames.size());
  progress.Start(input.frames.size());
  ParallelFor(input.frames.size(), num_threads, [&](std::size_t i) {
    failures[i] = FrameFailure(input.frames[i].color.path, [&] { search.Load(i); });
    progress.Advance();
  });
  for (const std::string& failure : failures) {
    if (!failure.empty()) result.skipped.push_back(failure);
  }
  if (!search.IsPublished()) search.FindMotions(num_threads);
  for (const Chain& chain : search.Chains()) {
    ParallelFor(chain.frames.size(), num_threads, [&](std::size_t k) { search.Gather(chain, k); });
    if (search.IsPublished()) continue;
    search.Decide(chain, num_threads);
    for (std::size_t k = 1; k < chain.frames.size(); ++k) {
      ++result.num_pairs;
      result.num_pairs_without_motion += !chain.next_from_previous[k];
    }
  }
  result.masks = search.TakeMasks();
  for (const auto& mask : result.masks) result.moving_shares.push_back(Share(mask));
  return result;
}

}  // namespace nightmap
