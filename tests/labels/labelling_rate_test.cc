// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/labelling_rate.h"

#include <algorithm>

#include "tests/test_data.h"

namespace nightmap {
namespace {

void AddSequence(int num_frames, double rate_hz, std::vector<FrameRecord>* frames) {
  const int sequence_idx = frames->empty() ? 0 : frames->back().sequence_idx + 1;
  const std::int64_t start_ns = frames->empty() ? 0 : frames->back().time_ns + 10'000'000'000;
  for (int i = 0; i < num_frames; ++i) {
    FrameRecord& frame = frames->emplace_back();
    frame.time_ns = start_ns + static_cast<std::int64_t>(1e9 * i / rate_hz);
    frame.sequence_idx = sequence_idx;
  }
}

std::vector<FrameRecord> Sequence(int num_frames, double rate_hz) {
  std::vector<FrameRecord> frames;
  AddSequence(num_frames, rate_hz, &frames);
  return frames;
}

std::vector<std::size_t> Chosen(const std::vector<FrameRecord>& frames, double rate_hz) {
  const std::vector<bool> is_chosen = FramesAtRate(frames, rate_hz);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < is_chosen.size(); ++i) {
    if (is_chosen[i]) chosen.push_back(i);
  }
  return chosen;
}

TEST(FramesAtRate, AreEveryNthOfEachSequence) {
  std::vector<FrameRecord> frames = Sequence(8, 30);
  EXPECT_THAT(Chosen(frames, 10), testing::ElementsAre(0, 3, 6));
  AddSequence(4, 20, &frames);
  EXPECT_THAT(Chosen(frames, 10), testing::ElementsAre(0, 3, 6, 8, 10));
  EXPECT_TRUE(FramesAtRate({}, 10).empty());
  EXPECT_THAT(Chosen(Sequence(1, 30), 0.01), testing::ElementsAre(0));
  EXPECT_THAT(Chosen(Sequence(5, 30), 1e-6), testing::ElementsAre(0));
}

TEST(FramesAtRate, AreAboutAsManyPerSecond) {
  const auto count = [](double rate_hz) { return Chosen(Sequence(61, rate_hz), 9).size(); };
  EXPECT_EQ(count(60), 9U);  // every seventh
  EXPECT_EQ(count(30), 21U);
  EXPECT_EQ(count(16), 31U);
  EXPECT_EQ(count(10), 61U);
  EXPECT_EQ(count(1), 61U);
}

TEST(FramesAtRate, GapsOfARecordingDoNotCount) {
  std::vector<FrameRecord> frames = Sequence(31, 30);
  for (std::size_t i = 10; i < frames.size(); ++i) frames[i].time_ns += 60'000'000'000;
  EXPECT_EQ(Chosen(frames, 9).size(), 11U);
}

}  // namespace
}  // namespace nightmap
