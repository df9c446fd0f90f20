// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/frames/frames.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::frames_test {

constexpr std::int64_t kPeriod_ns = 50'000'000;

RawSequence Sequence(const std::string& name, std::int64_t start_ns, int count) {
  RawSequence sequence;
  sequence.name = name;
  for (int i = 0; i < count; ++i) {
    const std::string file = name + "/" + std::to_string(i);
    RawFrame& frame = sequence.frames.emplace_back();
    frame.time_ns = start_ns + i * kPeriod_ns;
    frame.color = {file + ".png", "ff"};
    frame.depth = {file + "d.png", "dd"};
  }
  return sequence;
}

StampedPose At(std::int64_t time_ns, double x_m, double yaw_rad) {
  return {time_ns,
          {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), {x_m, 0, 0}}};
}

void ExpectContiguous(const std::vector<FrameRecord>& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].frame_idx, static_cast<int>(i));
    if (i == 0) continue;
    EXPECT_GT(frames[i].time_ns, frames[i - 1].time_ns);
  }
}

TEST(RunFrames, EveryFrameIsInExactlyOneList) {
  const auto lists = RunFrames({Sequence("a", 0, 23), Sequence("b", 10'000'000'000, 14)}, 5);
  EXPECT_EQ(lists.frames.size(), 30u);
  EXPECT_EQ(lists.held_out.size(), 7u);
  EXPECT_EQ(lists.num_inspected, 37u);
  ExpectContiguous(lists.frames);
  ExpectContiguous(lists.held_out);
  EXPECT_EQ(lists.held_out[0].color.path, "a/4.png");
  EXPECT_EQ(lists.held_out[4].color.path, "b/1.png");  // the 25th frame of the site
  EXPECT_EQ(lists.held_out[4].sequence_idx, 1);
}

TEST(RunFrames, ADamagedFrameMovesNoOther) {
  auto sequence = Sequence("a", 0, 20);
  const auto whole = RunFrames({sequence}, 5);
  sequence.frames[2].problem = "a/2.png: truncated";
  const auto damaged = RunFrames({sequence}, 5);
  EXPECT_EQ(damaged.skipped, std::vector<std::string>{"a/2.png: truncated"});
  EXPECT_EQ(damaged.frames.size() + 1, whole.frames.size());
  EXPECT_EQ(FramesToCsv(damaged.held_out), FramesToCsv(whole.held_out));
  ExpectContiguous(damaged.frames);
}

TEST(RunFrames, ADamagedHeldOutFrameIsReportedAndStays) {
  auto sequence = Sequence("a", 0, 20);
  const auto whole = RunFrames({sequence}, 5);
  sequence.frames[4].problem = "a/4.png: truncated";
  const auto damaged = RunFrames({sequence}, 5);
  EXPECT_EQ(damaged.skipped, std::vector<std::string>{"a/4.png: truncated"});
  EXPECT_EQ(FramesToCsv(damaged.held_out), FramesToCsv(whole.held_out));
  EXPECT_EQ(FramesToCsv(damaged.frames), FramesToCsv(whole.frames));
}

TEST(RunFrames, DepthOfAHeldOutFrameIsNoMatter) {
  auto sequence = Sequence("a", 0, 20);
  sequence.frames[4].depth_problem = "a/4.png: no depth";
  sequence.frames[5].depth_problem = "a/5.png: no depth";
  sequence.frames[5].depth = {};
  const auto lists = RunFrames({sequence}, 5);
  EXPECT_EQ(lists.skipped, std::vector<std::string>{"a/5.png: no depth"});
  EXPECT_EQ(lists.num_frames_unusable, 1u);
  EXPECT_EQ(lists.held_out.at(0).color.path, "a/4.png");
}

TEST(RunFrames, OptionalDepthAndLabelsCostTheFrameTheirChannelOnly) {
  auto sequence = Sequence("a", 0, 3);
  sequence.needs_depth = false;
  sequence.frames[1].depth_problem = "a/1d.png: truncated";
  sequence.frames[1].depth = {};
  sequence.frames[2].others_problems = {"labels/2.png: truncated"};
  const auto lists = RunFrames({sequence}, 0);
  EXPECT_EQ(lists.frames.size(), 3u);
  EXPECT_EQ(lists.num_frames_unusable, 0u);
  EXPECT_EQ(lists.skipped,
            (std::vector<std::string>{"a/1d.png: truncated", "labels/2.png: truncated"}));
}

TEST(RunFrames, ASiteMayHaveNoFrames) {
  const auto lists = RunFrames({}, 5);
  EXPECT_TRUE(lists.frames.empty() && lists.held_out.empty());
}

TEST(RunFrames, OverlappingSequencesAreRefused) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        RunFrames({Sequence("s:1", 0, 5), Sequence("s:9", 4 * kPeriod_ns, 5)}, 0),
                        "set time_offset_s");
  EXPECT_NO_THROW(RunFrames({Sequence("a", 0, 5), Sequence("b", 5 * kPeriod_ns, 5)}, 0));
}

// Cameras 1 and 0 of a rig, in this order, with the same times but for the second, which begins one
// frame later and has one more.
std::vector<RawSequence> Rig() {
  std::vector<RawSequence> sequences = {Sequence("right", 0, 4), Sequence("left", kPeriod_ns, 4)};
  for (RawSequence& sequence : sequences) sequence.rig = "head";
  for (RawFrame& frame : sequences[0].frames) frame.camera_idx = 1;
  return sequences;
}

TEST(RunFrames, CamerasOfARigAreMergedByTimeThenCamera) {
  auto sequences = Rig();
  for (const RawFrame& frame : sequences[0].frames)
    sequences[0].ground_truth.push_back(At(frame.time_ns, 1, 0));
  sequences.push_back(Sequence("next", 5 * kPeriod_ns, 1));
  const auto lists = RunFrames(sequences, 0);
  std::string order;
  std::vector<std::int64_t> times_ns;
  for (const FrameRecord& frame : lists.frames) {
    order += frame.color.path + " ";
    times_ns.push_back(frame.time_ns);
    EXPECT_EQ(frame.sequence_idx,
              frame.color.path[0] == 'r'   ? 0
              : frame.color.path[0] == 'l' ? 1
                                           : 2);
  }
  EXPECT_EQ(order,
            "right/0.png left/0.png right/1.png left/1.png right/2.png left/2.png right/3.png "
            "left/3.png next/0.png ");
  const std::int64_t t = kPeriod_ns;
  EXPECT_EQ(
      times_ns,
      (std::vector<std::int64_t>{0, t, t + 1, 2 * t, 2 * t + 1, 3 * t, 3 * t + 1, 4 * t, 5 * t}));
  ExpectContiguous(lists.frames);
  ASSERT_EQ(lists.ground_truth.size(), 4u);
  EXPECT_EQ(lists.ground_truth[1].time_ns, t + 1);  // the key of its frame
}

TEST(RunFrames, ADamagedFrameOfARigMovesNoTime) {
  auto sequences = Rig();
  const auto whole = RunFrames(sequences, 3);
  sequences[1].frames[1].problem = "left/1.png: truncated";
  const auto damaged = RunFrames(sequences, 3);
  EXPECT_EQ(FramesToCsv(damaged.held_out), FramesToCsv(whole.held_out));
  EXPECT_EQ(damaged.frames.size() + 1, whole.frames.size());
  for (const FrameRecord& frame : damaged.frames) {
    const auto same = std::ranges::find(
        whole.frames, frame.color.path, [](const FrameRecord& other) { return other.color.path; });
    ASSERT_NE(same, whole.frames.end());
    EXPECT_EQ(frame.time_ns, same->time_ns);
  }
}

TEST(RunFrames, OnlyDifferentCamerasOfOneRigMayOverlap) {
  const auto refused = [](const auto& change) {
    auto sequences = Rig();
    change(sequences);
    NIGHTMAP_EXPECT_ERROR(
        DataError, RunFrames(sequences, 0), "cameras that record at once need the same `rig`");
  };
  EXPECT_NO_THROW(RunFrames(Rig(), 0));
  refused([](auto& sequences) { sequences[1].rig = "feet"; });
  refused([](auto& sequences) { sequences[0].rig = sequences[1].rig = ""; });
  refused([](auto& sequences) {
    for (RawFrame& frame : sequences[1].frames) frame.camera_idx = 1;
  });
  refused([](auto& sequences) {  // a recording of no rig between them, and one after them that
                                 // begins early
    sequences.insert(sequences.begin() + 1, Sequence("between", 10 * kPeriod_ns, 1));
  });
  refused([](auto& sequences) { sequences.push_back(Sequence("next", 4 * kPeriod_ns, 1)); });
}

TEST(RunFrames, TruthIsExactInterpolatedOrAbsent) {
  auto sequence = Sequence("a", 0, 10);  // 0, 50 ... 450 ms
  sequence.ground_truth = {At(0, 0, 0),
                           At(40'000'000, 4, 0.4),
                           At(60'000'000, 6, 0.6),
                           At(100'000'000, 7, 1),
                           At(300'000'000, 9, 2),  // 200 ms later: a dropout
                           At(400'000'000, 8, 2.2)};
  const auto truth = RunFrames({sequence}, 0).ground_truth;
  std::vector<std::int64_t> times_ms;
  for (const StampedPose& pose : truth) times_ms.push_back(pose.time_ns / 1'000'000);
  EXPECT_EQ(times_ms, (std::vector<std::int64_t>{0, 50, 100, 300, 350, 400}));
  EXPECT_NEAR(truth[1].pose.translation.x(), 5, 1e-12);
  EXPECT_NEAR(AngleBetween_rad(truth[1].pose, At(0, 0, 0.5).pose), 0, 1e-7);
  EXPECT_EQ(truth[2].pose.translation.x(), 7);
  EXPECT_NEAR(truth[4].pose.translation.x(), 8.5, 1e-12);
}

TEST(RunFrames, HeldOutFramesHaveTheirTruthApart) {
  auto sequence = Sequence("a", 0, 10);
  for (const RawFrame& frame : sequence.frames)
    sequence.ground_truth.push_back(At(frame.time_ns, 0, 0));
  const auto lists = RunFrames({sequence}, 5);
  EXPECT_EQ(lists.ground_truth.size(), 8u);
  ASSERT_EQ(lists.held_out_ground_truth.size(), 2u);
  EXPECT_EQ(lists.held_out_ground_truth[1].time_ns, lists.held_out[1].time_ns);
}

TEST(SelectFrames, StrideAndLimitThinTheRecordings) {
  std::vector<RawSequence> sequences = {Sequence("a", 0, 10), Sequence("b", 0, 10)};
  FramesOptions options;
  options.stride = 3;
  options.max_frames = 6;
  EXPECT_EQ(SelectFrames(options, &sequences), 2u);  // 6 and 9 of b
  EXPECT_EQ(sequences[0].frames.size(), 4u);         // 0 3 6 9
  EXPECT_EQ(sequences[0].frames[3].color.path, "a/9.png");
  EXPECT_EQ(sequences[1].frames.size(), 2u);
  options = {};
  EXPECT_EQ(SelectFrames(options, &sequences), 0u);
}

TEST(SelectFrames, ALimitKeepsTheFirstMomentsOfARig) {
  auto sequences = Rig();
  FramesOptions options;
  options.max_frames = 5;
  EXPECT_EQ(SelectFrames(options, &sequences), 3u);
  EXPECT_EQ(sequences[0].frames.size(), 3u);
  EXPECT_EQ(sequences[1].frames.size(), 2u);
}

TEST(CutShards, AppendingFramesChangesTheLastShardOnly) {
  const auto before = CutShards(RunFrames({Sequence("a", 0, 25)}, 0).frames, 10);
  const auto after = CutShards(RunFrames({Sequence("a", 0, 34)}, 0).frames, 10);
  ASSERT_EQ(before.size(), 3u);
  ASSERT_EQ(after.size(), 4u);
  EXPECT_EQ(before[2].size(), 5u);
  EXPECT_EQ(FramesToCsv(after[0]), FramesToCsv(before[0]));
  EXPECT_EQ(FramesToCsv(after[1]), FramesToCsv(before[1]));
  EXPECT_TRUE(CutShards({}, 10).empty());
}

TEST(FramesOptions, DefaultConfigFileIsWhatTheProgramHas) {
  FramesOptions options, from_file;
  RegisterOptions(from_file).ParseToml(ReadBytes("configs/recording/default/frames.toml"),
                                       "frames.toml");
  EXPECT_EQ(RegisterOptions(from_file).ToToml(), RegisterOptions(options).ToToml());
}

}  // namespace nightmap::frames_test
