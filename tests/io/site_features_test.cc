// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/site_features.h"

#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::site_features_test {

constexpr int kPerShard = 5;

FeaturesShard MakeShard(int first_frame_idx) {
  FeaturesShard shard;
  shard.kind = DescriptorKind::kOrb;
  shard.descriptor_size = DescriptorSize(shard.kind);
  shard.extraction = "detector = \"orb\"\n";
  for (int idx = first_frame_idx; idx < first_frame_idx + kPerShard; ++idx) {
    FrameFeatures& frame = shard.frames.emplace_back();
    frame.frame_idx = idx;
    for (int i = 0; i < 1 + idx % 3; ++i) {
      const auto value = static_cast<float>(10 * idx + i);
      frame.keypoints_px.emplace_back(value, value);
      frame.raw_keypoints_px.emplace_back(value, value + 1);
      frame.scales_px.push_back(value);
      frame.depths_m.push_back(value);
      frame.descriptors.resize(frame.descriptors.size() + 32, static_cast<std::uint8_t>(idx));
    }
  }
  return shard;
}

// A site of 8 shards whose frames begin with 3.
class SiteFeaturesTest : public InFolder {
 protected:
  static constexpr int kFirst = 3;

  SiteFeaturesTest() {
    for (int i = 0; i < 8; ++i) {
      const FeaturesShard shard = MakeShard(kFirst + i * kPerShard);
      paths_.push_back(folder_ / (std::to_string(i) + ".h5"));
      WriteFeatures(paths_.back(), shard, "");
      all_.insert(all_.end(), shard.frames.begin(), shard.frames.end());
      lists_.push_back(WriteList(i, shard.frames.size()));
    }
  }

  std::filesystem::path WriteList(int shard, std::size_t num_frames) {
    std::vector<FrameRecord> frames(num_frames);
    for (std::size_t i = 0; i < num_frames; ++i) {
      frames[i].frame_idx = kFirst + shard * kPerShard + static_cast<int>(i);
      frames[i].color = {std::to_string(i) + ".png", "hash"};
    }
    return folder_.Write(std::to_string(shard) + ".csv", FramesToCsv(frames));
  }

  void ExpectAll(const SiteFeatures& features) const {
    Random random(3);
    std::vector<int> asked;
    for (int i = 0; i < 300; ++i) asked.push_back(kFirst + static_cast<int>(random.Index(40)));
    std::vector<char> are_equal(asked.size());
    ParallelFor(asked.size(), 4, [&](std::size_t i) {
      const auto place = static_cast<std::size_t>(asked[i] - kFirst);
      are_equal[i] = *features.GetFrame(asked[i]) == all_[place];
    });
    EXPECT_EQ(std::ranges::count(are_equal, 1), std::ssize(asked));
    EXPECT_EQ(features.All().frames, all_);
    ASSERT_EQ(features.Heads().frames.size(), all_.size());
    for (std::size_t i = 0; i < all_.size(); ++i) {
      EXPECT_EQ(features.NumFeatures(i), all_[i].NumFeatures());
    }
    EXPECT_EQ(features.FirstFrame(), kFirst);
  }

  std::vector<std::filesystem::path> paths_, lists_;
  std::vector<FrameFeatures> all_;
};

TEST_F(SiteFeaturesTest, FramesAreTheSameWhateverFitsIntoMemory) {
  for (const std::size_t max_bytes : {std::size_t{1}, std::size_t{3000}, SiteFeatures::kMaxBytes}) {
    ExpectAll(SiteFeatures(paths_, lists_, max_bytes));
  }
  FeaturesShard whole = MakeShard(0);
  whole.frames = all_;
  ExpectAll(SiteFeatures(whole));
}

TEST_F(SiteFeaturesTest, AShardStaysWhileItIsUsed) {
  const SiteFeatures features(paths_, {}, 1);
  const SiteFeatures::Frame first = features.GetFrame(kFirst);
  for (int idx = kFirst; idx < kFirst + 40; ++idx) features.GetFrame(idx);
  EXPECT_EQ(*first, all_[0]);
}

TEST_F(SiteFeaturesTest, ShardsWithoutFramesAreNoPlaceOfAny) {
  FeaturesShard empty = MakeShard(0);
  empty.frames.clear();
  const auto path = folder_ / "empty.h5";
  WriteFeatures(path, empty, "");
  for (const std::ptrdiff_t at : {0, 3, 8}) {
    auto paths = paths_;
    paths.insert(paths.begin() + at, path);
    ExpectAll(SiteFeatures(paths, {}));
  }
}

TEST_F(SiteFeaturesTest, AChangeIsMadeEachTimeAShardIsRead) {
  const SiteFeatures features(paths_, lists_, 1);
  const SiteFeatures changed = features.With([](FeaturesShard* shard) {
    for (FrameFeatures& frame : shard->frames) frame.depths_m.assign(frame.depths_m.size(), 7);
  });
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const auto frame = changed.GetFrame(kFirst + static_cast<int>(i));
      EXPECT_EQ(frame->depths_m, std::vector<float>(all_[i].depths_m.size(), 7));
      EXPECT_EQ(frame->descriptors, all_[i].descriptors);
    }
  }
  ExpectAll(features);
}

TEST_F(SiteFeaturesTest, ShardsOfOtherOptionsAreNamed) {
  FeaturesShard other = MakeShard(kFirst + kPerShard);
  other.extraction = "detector = \"brisk\"\n";
  WriteFeatures(paths_[1], other, "");
  NIGHTMAP_EXPECT_ERROR(DataError, SiteFeatures(paths_, {}), "1.h5: extracted with other options");
}

TEST_F(SiteFeaturesTest, ShardsThatDoNotFollowEachOtherAreNamed) {
  std::swap(paths_[1], paths_[2]);
  NIGHTMAP_EXPECT_ERROR(
      DataError,
      SiteFeatures(paths_, {}),
      paths_[1].string() + " does not hold the frames that follow those of " + paths_[0].string());
}

TEST_F(SiteFeaturesTest, AListOfOtherFramesIsNamed) {
  WriteList(1, kPerShard - 1);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        SiteFeatures(paths_, lists_),
                        lists_[1].string() + " does not list the frames that " +
                            paths_[1].string() + " has features of");
  lists_.pop_back();
  NIGHTMAP_EXPECT_ERROR(UsageError, SiteFeatures(paths_, lists_), "8 and 7");
}

TEST_F(SiteFeaturesTest, AFileThatIsDamagedBelowItsHeadsIsNamedWhenItIsRead) {
  const SiteFeatures features(paths_, lists_, 1);
  features.GetFrame(kFirst);
  FeaturesShard damaged = MakeShard(kFirst + kPerShard);
  damaged.frames[2].depths_m[0] = -1;
  WriteFeatures(paths_[1], damaged, "");
  NIGHTMAP_EXPECT_ERROR(DataError, features.GetFrame(kFirst + kPerShard), "1.h5", "depth_m");
}

}  // namespace nightmap::site_features_test
