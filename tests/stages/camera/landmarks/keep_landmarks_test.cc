// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/keep_landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "pipeline/base/random.h"

namespace nightmap::keep_landmarks_test {

Landmark SeenBy(const std::vector<int>& observers) {
  Landmark landmark;
  for (const int observer : observers) landmark.sightings.push_back({observer, 0});
  return landmark;
}

// A room that observers `first` to `last` walk through; each landmark is seen by up to `num_seeing`
// of them in a row.
void AddRoom(int first, int last, int num_landmarks, int num_seeing, std::vector<Landmark>* all) {
  Random random(3, static_cast<std::uint64_t>(first));
  for (int i = 0; i < num_landmarks; ++i) {
    const int begin =
        first + static_cast<int>(random.Index(static_cast<std::size_t>(last - first)));
    std::vector<int> observers;
    for (int k = begin; k < std::min(last, begin + num_seeing); ++k) observers.push_back(k);
    all->push_back(SeenBy(observers));
  }
}

std::vector<int> NumSeen(const std::vector<Landmark>& landmarks,
                         const std::vector<std::size_t>& chosen,
                         std::size_t num_observers) {
  std::vector<int> count(num_observers, 0);
  for (const std::size_t i : chosen) {
    for (const Sighting& s : landmarks[i].sightings) {
      ++count[static_cast<std::size_t>(s.frame_idx)];
    }
  }
  return count;
}

std::vector<std::size_t> All(const std::vector<Landmark>& landmarks) {
  std::vector<std::size_t> all(landmarks.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

TEST(ChooseLandmarks, KeepsAllInOrderWhenTheyAreNotTooMany) {
  std::vector<Landmark> landmarks;
  AddRoom(0, 10, 50, 4, &landmarks);
  EXPECT_EQ(ChooseLandmarks(landmarks, 10, 50), All(landmarks));
  EXPECT_EQ(ChooseLandmarks(landmarks, 10, 51), All(landmarks));
}

// A hall walked through slowly, whose landmarks most observers see; an office that is only glanced
// at; a bare corridor, which has none to spare.
TEST(ChooseLandmarks, NoRoomIsLostAtHalf) {
  constexpr std::size_t kNumObservers = 130;
  std::vector<Landmark> landmarks;
  AddRoom(0, 100, 3000, 12, &landmarks);
  AddRoom(100, 110, 500, 3, &landmarks);
  AddRoom(110, 130, 60, 2, &landmarks);
  const auto before = NumSeen(landmarks, All(landmarks), kNumObservers);
  const std::size_t half = landmarks.size() / 2;
  const auto chosen = ChooseLandmarks(landmarks, kNumObservers, half);
  ASSERT_EQ(chosen.size(), half);
  EXPECT_TRUE(std::ranges::is_sorted(chosen));
  const auto after = NumSeen(landmarks, chosen, kNumObservers);
  for (std::size_t i = 0; i < kNumObservers; ++i) {
    EXPECT_GE(after[i], std::min(before[i], 100)) << "observer " << i << " of " << before[i];
  }
}

// Everyone has chosen about as often.
TEST(ChooseLandmarks, EachObserverKeepsItsBest) {
  constexpr std::size_t kNumObservers = 40;
  std::vector<Landmark> landmarks;
  AddRoom(0, 30, 900, 6, &landmarks);
  AddRoom(30, 40, 300, 2, &landmarks);
  const auto chosen = ChooseLandmarks(landmarks, kNumObservers, 400);
  std::vector<bool> is_chosen(landmarks.size(), false);
  for (const std::size_t i : chosen) is_chosen[i] = true;
  std::size_t least_of_best = landmarks.size();
  for (int observer = 0; observer < static_cast<int>(kNumObservers); ++observer) {
    std::vector<std::size_t> seen;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const auto& sightings = landmarks[i].sightings;
      if (std::ranges::count(sightings, observer, &Sighting::frame_idx)) seen.push_back(i);
    }
    std::ranges::stable_sort(
        seen, std::greater<>(), [&](std::size_t i) { return landmarks[i].sightings.size(); });
    const auto first_dropped =
        std::ranges::find_if(seen, [&](std::size_t i) { return !is_chosen[i]; });
    least_of_best = std::min(least_of_best, static_cast<std::size_t>(first_dropped - seen.begin()));
  }
  EXPECT_GE(least_of_best, 400 / kNumObservers) << "turns of all, before some chose the same";
}

TEST(ChooseLandmarks, FewerThanObserversAreTheMostSeen) {
  std::vector<Landmark> landmarks = {SeenBy({0}), SeenBy({1, 2}), SeenBy({0, 1, 2}), SeenBy({3})};
  EXPECT_EQ(ChooseLandmarks(landmarks, 4, 1), (std::vector<std::size_t>{2}));
  EXPECT_EQ(ChooseLandmarks(landmarks, 4, 2), (std::vector<std::size_t>{2, 3}));
}

}  // namespace nightmap::keep_landmarks_test
