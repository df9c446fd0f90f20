// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/doubtful_loops.h"

#include <algorithm>
#include <map>

namespace nightmap {
namespace {

constexpr double kAgreement_m = 0.5;

class Judge {
 public:
  Judge(const ScanLoopsOptions& options,
        const std::vector<Keyscan>& keyscans,
        const DriftSums& drifts)
      : options_(options), keyscans_(keyscans), drifts_(drifts) {}

  bool IsDoubtful(const ScanLoopCandidate& loop, const ScanLoopCandidate& other) const {
    if (other.score == 0 || other.submap_keyscan == loop.submap_keyscan) return false;
    if (other.second_score > 0) return other.score > options_.max_second_ratio * loop.score;
    return loop.score < options_.max_second_ratio * other.score && !Agree(loop, other);
  }

 private:
  // Whether both put the query at one place.
  bool Agree(const ScanLoopCandidate& loop, const ScanLoopCandidate& other) const {
    const Rigid2 submap_from_other = keyscans_[loop.submap_keyscan].start_from_robot.Inverse() *
                                     keyscans_[other.submap_keyscan].start_from_robot;
    const Rigid2 by_other = submap_from_other * ToRigid2(other.query_from_submap).Inverse();
    const Rigid2 by_loop = ToRigid2(loop.query_from_submap).Inverse();
    const auto [first, last] = std::minmax(loop.submap_keyscan, other.submap_keyscan);
    const double reach_m = kAgreement_m + 3 * drifts_.Between(first, last).Sigma_m();
    return (by_loop.translation - by_other.translation).norm() <= reach_m;
  }

  const ScanLoopsOptions& options_;
  const std::vector<Keyscan>& keyscans_;
  const DriftSums& drifts_;
};

}  // namespace

void DropDoubtfulLoops(const ScanLoopsOptions& options,
                       const std::vector<Keyscan>& keyscans,
                       const DriftSums& drifts,
                       std::vector<ScanLoopCandidate>* candidates) {
  const Judge judge(options, keyscans, drifts);
  std::map<std::size_t, std::vector<std::size_t>> of_query;
  for (std::size_t i = 0; i < candidates->size(); ++i) {
    of_query[(*candidates)[i].query_keyscan].push_back(i);
  }
  std::vector<std::size_t> doubtful;
  for (const auto& [query, all] : of_query) {
    for (const std::size_t loop : all) {
      const bool is_doubtful = std::ranges::any_of(all, [&](std::size_t other) {
        return judge.IsDoubtful((*candidates)[loop], (*candidates)[other]);
      });
      if ((*candidates)[loop].is_loop && is_doubtful) doubtful.push_back(loop);
    }
  }
  for (const std::size_t loop : doubtful) (*candidates)[loop].is_loop = false;
}

}  // namespace nightmap
