// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/keep_landmarks.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace nightmap {
namespace {

// All landmarks, those with most observers first; ties: the older.
std::vector<std::size_t> MostSeenFirst(const std::vector<Landmark>& landmarks) {
  std::vector<std::size_t> order(landmarks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, std::greater<>(), [&](std::size_t i) { return landmarks[i].sightings.size(); });
  return order;
}

// The turn in which each landmark is first chosen.
std::vector<std::size_t> Turns(const std::vector<Landmark>& landmarks,
                               const std::vector<std::size_t>& most_seen_first,
                               std::size_t num_observers) {
  std::vector<std::size_t> num_chosen(num_observers, 0);
  std::vector<std::size_t> turns(landmarks.size(), std::numeric_limits<std::size_t>::max());
  for (const std::size_t i : most_seen_first) {
    for (const Sighting& s : landmarks[i].sightings) {
      turns[i] = std::min(turns[i], num_chosen[static_cast<std::size_t>(s.frame_idx)]++);
    }
  }
  return turns;
}

}  // namespace

std::vector<std::size_t> ChooseLandmarks(const std::vector<Landmark>& landmarks,
                                         std::size_t num_observers,
                                         std::size_t count) {
  std::vector<std::size_t> chosen = MostSeenFirst(landmarks);
  if (chosen.size() > count) {
    const auto turns = Turns(landmarks, chosen, num_observers);
    std::ranges::stable_sort(chosen, {}, [&](std::size_t i) { return turns[i]; });
    chosen.resize(count);
  }
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace nightmap
