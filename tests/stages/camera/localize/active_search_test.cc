// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/active_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>

#include "pipeline/camera/descriptor_distance.h"
#include "stages/camera/localize/place_search.h"
#include "tests/stages/camera/localize/scene_map.h"

namespace nightmap::active_search_test {

class SearchTest : public testing::Test {
 protected:
  SearchTest() { features_ = scene_.See(pose_, 0, &seen_); }

  std::vector<LandmarkMatch> Search(const std::string& search) {
    options_.search = search;
    const LandmarkIndex index(options_, map_, vocabulary_);
    return ActiveSearch(options_, index, features_).Run();
  }

  const std::uint8_t* Descriptor(int feature) const {
    return &features_.descriptors[static_cast<std::size_t>(128 * feature)];
  }

  // Matches of more than a share of the features, each to the landmark that it shows.
  void ExpectRight(const std::vector<LandmarkMatch>& matches, double min_ratio) const {
    EXPECT_GT(static_cast<double>(matches.size()), min_ratio * static_cast<double>(seen_.size()));
    for (const LandmarkMatch& match : matches) {
      EXPECT_EQ(match.landmark, seen_[static_cast<std::size_t>(match.feature)]);
    }
  }
  // So much that some features have another word, or are no clear match, and some are still.
  void AddNoise() {
    Random random(21);
    for (std::uint8_t& value : features_.descriptors) {
      const double noisy = value + 9 * random.Gaussian();
      value = static_cast<std::uint8_t>(std::clamp(noisy, 0.0, 255.0));
    }
  }

  // A candidate of either side, and where it is: metres in the map, or pixels.
  struct Candidate {
    int distance;
    int idx;
    Eigen::Vector3d place;
  };
  // The nearest in descriptor, when it is clearly nearer than any in another place; or -1.
  int ClearBest(const std::vector<Candidate>& found, double same_place, double max_ratio) const {
    const double max_distance = std::pow(512 * options_.max_descriptor_distance, 2);
    const auto best = std::ranges::min_element(found, {}, &Candidate::distance);
    if (best == found.end() || best->distance > max_distance) return -1;
    double second = std::numeric_limits<double>::infinity();
    for (const Candidate& other : found) {
      if ((other.place - best->place).norm() <= same_place) continue;
      second = std::min(second, static_cast<double>(other.distance));
    }
    if (std::isinf(second)) second = max_distance;
    return best->distance < max_ratio * max_ratio * second ? best->idx : -1;
  }

  // Brute-force matches over all landmarks with the word of a feature.
  std::vector<LandmarkMatch> BruteForceOfFeatures() const {
    std::vector<LandmarkMatch> matches;
    for (int f = 0; f < features_.NumFeatures(); ++f) {
      const int word = vocabulary_.tree.Word(Descriptor(f), options_.search_level);
      std::vector<Candidate> found;
      for (int d = 0; d < map_.NumDescriptors(); ++d) {
        if (map_.Word(d, options_.search_level) != word) continue;
        found.push_back({SquaredDistance(Descriptor(f), map_.Descriptor(d), 128),
                         d,
                         map_.positions_in_map[static_cast<std::size_t>(d)]});
      }
      const int best = ClearBest(found, options_.same_point_radius_m, options_.max_ratio);
      if (best < 0) continue;
      matches.push_back({f, best, SquaredDistance(Descriptor(f), map_.Descriptor(best), 128)});
    }
    return KeepOneToOne(matches);
  }

  // Brute-force matches over all features with the word of a landmark, those most seen first; each
  // feature once.
  std::map<int, int> BruteForceOfLandmarks() const {
    std::vector<int> landmarks(map_.positions_in_map.size());
    std::iota(landmarks.begin(), landmarks.end(), 0);
    std::ranges::stable_sort(landmarks, std::greater<>(), [&](int i) {
      return map_.landmark_keyframes[static_cast<std::size_t>(i)].size();
    });
    std::map<int, int> landmark_of;
    for (const int d : landmarks) {
      std::vector<Candidate> found;
      for (int f = 0; f < features_.NumFeatures(); ++f) {
        if (vocabulary_.tree.Word(Descriptor(f), options_.landmark_level) !=
            map_.Word(d, options_.landmark_level)) {
          continue;
        }
        const auto& pixel = features_.keypoints_px[static_cast<std::size_t>(f)];
        found.push_back({SquaredDistance(Descriptor(f), map_.Descriptor(d), 128),
                         f,
                         {pixel.x(), pixel.y(), 0}});
      }
      const int best = ClearBest(found, 5, options_.max_landmark_ratio);
      if (best >= 0) landmark_of.try_emplace(best, d);
    }
    return landmark_of;
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  VocabularyIndex vocabulary_ = IndexOf(MakeSceneVocabulary(scene_));
  LandmarkMap map_ = MakeSceneMap(scene_, vocabulary_.tree);
  LocalizeOptions options_;
  Rigid3 pose_ = ScenePose(0.15, -0.1);
  std::vector<int> seen_;
  FrameFeatures features_;
};

TEST_F(SearchTest, EverySearchFindsTheRightLandmarks) {
  for (const char* search : {"combined", "2d_to_3d", "3d_to_2d", "tree"}) {
    SCOPED_TRACE(search);
    ExpectRight(Search(search), 0.5);
  }
}

TEST_F(SearchTest, FeaturesToLandmarksIsWhatBruteForceFinds) {
  options_.max_matches = 100000;
  AddNoise();
  const auto expected = BruteForceOfFeatures();
  EXPECT_GT(expected.size(), seen_.size() / 4);
  EXPECT_LT(expected.size(), seen_.size());
  EXPECT_EQ(Search("2d_to_3d"), expected);
}

TEST_F(SearchTest, LandmarksToFeaturesIsWhatBruteForceFinds) {
  options_.max_matches = 100000;
  options_.landmark_level = 2;  // words of more than one feature
  AddNoise();
  const auto expected = BruteForceOfLandmarks();
  const auto matches = Search("3d_to_2d");
  EXPECT_GT(expected.size(), seen_.size() / 4);
  EXPECT_LT(expected.size(), seen_.size());
  ASSERT_EQ(matches.size(), expected.size());
  for (const LandmarkMatch& match : matches) {
    EXPECT_EQ(match.landmark, expected.at(match.feature));
  }
}

TEST_F(SearchTest, StopsAtThePresetNumber) {
  options_.max_matches = 20;
  for (const char* search : {"combined", "2d_to_3d", "3d_to_2d"}) {
    EXPECT_EQ(Search(search).size(), 20U) << search;
  }
}

// Every other landmark has wrong words down to search_level. Only the search around a match finds
// it, by its word at landmark_level.
TEST_F(SearchTest, TheCombinedSearchFindsWhatWordsMiss) {
  options_.max_matches = 100000;
  const int depth = map_.num_word_levels;
  for (int i = 0; i < map_.NumDescriptors(); i += 2) {
    std::fill_n(map_.words.begin() + i * depth, options_.search_level, 0);
  }
  const std::size_t num_by_words = Search("2d_to_3d").size();
  EXPECT_LT(num_by_words, 0.7 * static_cast<double>(seen_.size()));
  const auto matches = Search("combined");
  EXPECT_GT(static_cast<double>(matches.size()), 1.3 * static_cast<double>(num_by_words));
  ExpectRight(matches, 0);
  options_.num_nearest_landmarks = 0;
  EXPECT_EQ(Search("combined").size(), num_by_words);
}

// The same descriptor at two distant points is ambiguous, at two near ones it is not.
TEST_F(SearchTest, RatioTestComparesDifferentPoints) {
  const LandmarkMap map = map_;
  for (const bool near : {true, false}) {
    map_ = map;
    AddTwin({Eigen::Quaterniond::Identity(), {near ? 0.01 : 1.0, 0, 0}}, &map_);
    EXPECT_EQ(Search("2d_to_3d").empty(), !near);
  }
}

TEST_F(SearchTest, NearestLandmarksAreThoseOfBruteForce) {
  const LandmarkIndex index(options_, map_, vocabulary_);
  std::vector<int> order;
  for (int i = 1; i < map_.NumLandmarks(); ++i) order.push_back(i);
  std::ranges::sort(
      order, {}, [&](int i) { return (index.Position(i) - index.Position(0)).norm(); });
  order.resize(20);
  EXPECT_EQ(index.Nearest(0, 20), order);
  EXPECT_EQ(index.Nearest(0, 100000).size(), map_.positions_in_map.size() - 1);
}

TEST_F(SearchTest, APictureWithoutFeaturesMatchesNothing) {
  features_ = FrameFeatures{};
  for (const char* search : {"combined", "2d_to_3d", "3d_to_2d", "tree"}) {
    EXPECT_TRUE(Search(search).empty()) << search;
  }
}

TEST_F(SearchTest, RetrievalAndAPoseFindTheRightLandmarks) {
  const LandmarkIndex index(options_, map_, vocabulary_);
  auto found = SearchByRetrieval(options_, index, features_);
  ASSERT_EQ(found.size(), 1U);
  found.push_back(
      SearchByPose(options_, index, features_, scene_.cameras[0].color, pose_.Inverse(), seen_));
  for (const auto& matches : found) ExpectRight(matches, 0.5);
}

// Undistorted, the corners of a picture of a wide lens lie far outside of it.
TEST_F(SearchTest, APoseFindsLandmarksToTheEdgeOfAWideLens) {
  scene_.cameras[0].color = Camera{400, 240, 260, 260, 199.5, 119.5, -0.2};
  seen_.clear();
  features_ = scene_.See(pose_, 0, &seen_);
  int num_outside = 0;
  for (Eigen::Vector2f& pixel : features_.keypoints_px) {
    pixel = scene_.cameras[0].color.Undistort(pixel.cast<double>()).cast<float>();
    num_outside += !scene_.cameras[0].color.Contains(pixel.cast<double>());
  }
  EXPECT_GT(num_outside, 10);
  features_.keypoints_px[0].x() = std::numeric_limits<float>::quiet_NaN();
  const LandmarkIndex index(options_, map_, vocabulary_);
  ExpectRight(
      SearchByPose(options_, index, features_, scene_.cameras[0].color, pose_.Inverse(), seen_),
      0.95);
}

TEST_F(SearchTest, RivalsAreTheTwins) {
  const auto matches = Search("2d_to_3d");
  EXPECT_TRUE(
      SearchRivals(options_, LandmarkIndex(options_, map_, vocabulary_), features_, {}).empty());
  const int num_landmarks = map_.NumLandmarks();
  AddTwin({Eigen::Quaterniond::Identity(), {20, 0, 0}}, &map_);
  const LandmarkIndex index(options_, map_, vocabulary_);
  const auto rivals = SearchRivals(options_, index, features_, matches);
  EXPECT_EQ(rivals.size(), matches.size());
  for (const LandmarkMatch& rival : rivals) {
    EXPECT_EQ(rival.landmark - num_landmarks, seen_[static_cast<std::size_t>(rival.feature)]);
  }
}

TEST_F(SearchTest, TheLargestPlaceIsKept) {
  const int num_landmarks = map_.NumLandmarks();
  auto matches = Search("2d_to_3d");
  AddTwin({Eigen::Quaterniond::Identity(), {20, 0, 0}}, &map_);
  const LandmarkIndex index(options_, map_, vocabulary_);
  const std::size_t num_strays = matches.size() / 3;
  for (std::size_t i = 0; i < num_strays; ++i) matches[i].landmark += num_landmarks;
  const auto kept = LargestPlace(index, matches);
  EXPECT_LE(kept.size(), matches.size() - num_strays);
  EXPECT_GT(kept.size(), matches.size() / 2);
  for (const LandmarkMatch& match : kept) EXPECT_LT(match.landmark, num_landmarks);
}

}  // namespace nightmap::active_search_test
