// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/inspect/inspect.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pipeline/io/image_io.h"
#include "tests/test_data.h"

namespace nightmap::inspect_test {

TEST(DescribeTimes, RateGapsAndExtent) {
  std::vector<std::int64_t> times_ns;
  for (int i = 0; i < 100; ++i) times_ns.push_back(1'000'000'000 + i * 20'000'000LL);
  for (int i = 60; i < 100; ++i) times_ns[static_cast<std::size_t>(i)] += 500'000'000;
  const auto series = DescribeTimes("imu", "acceleration", times_ns);
  EXPECT_EQ(series.count, 100u);
  EXPECT_NEAR(series.rate_hz, 50, 1e-9);
  EXPECT_NEAR(series.largest_gap_s, 0.52, 1e-9);
  EXPECT_EQ(series.num_gaps, 1u);
  EXPECT_EQ(series.first_ns, times_ns.front());
  EXPECT_EQ(series.last_ns, times_ns.back());
  EXPECT_EQ(DescribeTimes("a", "b", {}).rate_hz, 0);
  EXPECT_EQ(DescribeTimes("a", "b", {5}).num_gaps, 0u);
}

// Three frames of one recording, of which one has no depth, and an accelerometer.
class InspectTest : public testing::Test {
 protected:
  InspectTest() {
    RgbdCamera camera;
    camera.color = {.width = 4, .height = 2, .fx = 3, .fy = 3, .cx = 1, .cy = 1};
    camera.max_depth_m = 5;
    site_.cameras = {camera};
    std::filesystem::create_directories(folder_ / "");
    const std::vector<std::uint16_t> depth = {0, 0, 1500, 2000, 0, 65535, 0, 9000};
    for (int i = 0; i < 3; ++i) {
      RawFrame& frame = sequence_.frames.emplace_back();
      frame.time_ns = (10 + i) * kSecond_ns;
      frame.color.path = fmt::format("{}.png", i);
      WritePng(folder_ / frame.color.path, ColorImage{4, 2, 3, std::vector<std::uint8_t>(24)});
      if (i == 1) continue;
      frame.depth.path = fmt::format("{}d.png", i);
      WritePng(folder_ / frame.depth.path, RawDepthImage{4, 2, 1, depth});
    }
    imu_.sensor_id = "imu";
    for (int i = 0; i < 11; ++i) {
      imu_.samples.push_back({11 * kSecond_ns + i * kSecond_ns / 10, {0.5 * i, -9.8, 0}, {}});
    }
  }
  std::vector<ChannelSeries> Run() const {
    return RunInspect({sequence_}, {imu_}, [&](const RawSequence& sequence) {
      return SampledPictures(sequence, site_, folder_.Path(), 20);
    });
  }

  static constexpr std::int64_t kSecond_ns = 1'000'000'000;
  TemporaryFolder folder_;
  SiteConfig site_;
  RawSequence sequence_;
  Signal imu_;
};

TEST_F(InspectTest, EachChannelIsCountedAndDescribed) {
  const auto series = Run();
  ASSERT_EQ(series.size(), 3u);
  EXPECT_EQ(series[0].channel, "color");
  EXPECT_EQ(series[0].count, 3u);
  EXPECT_EQ(series[0].details, "4 x 2, 3 of 8 bits");
  EXPECT_EQ(series[1].channel, "depth");
  EXPECT_EQ(series[1].count, 2u);
  EXPECT_EQ(series[1].details, "4 x 2, 1 of 16 bits, 1.50 to 2.00 m, 25 % measured");
  EXPECT_EQ(series[2].details, "ax 0 to 5 m/s2, ay -9.8 to -9.8 m/s2, az 0 to 0 m/s2");
  EXPECT_NEAR(series[2].rate_hz, 10, 1e-9);
}

TEST_F(InspectTest, TheTimeInCommonIsTold) {
  EXPECT_THAT(InspectionText(Run()),
              testing::HasSubstr("recording 0 and imu: 1.0 s, 50 % of the recording"));
  for (SignalSample& sample : imu_.samples) sample.time_ns += 100 * kSecond_ns;
  EXPECT_THAT(InspectionText(Run()), testing::HasSubstr("imu: 0.0 s, 0 % of the recording"));
}

TEST_F(InspectTest, PicturesThatCannotBeReadAreCounted) {
  folder_.Write("0.png", "hello");
  std::filesystem::remove(folder_ / "2d.png");
  const auto series = Run();
  EXPECT_EQ(series[0].details, "4 x 2, 3 of 8 bits, 1 of 3 looked at cannot be read");
  EXPECT_THAT(series[1].details, testing::HasSubstr("1 of 3 looked at cannot be read"));
}

TEST_F(InspectTest, ScansAreDescribedByTheirBeams) {
  Signal laser{SignalKind::kScan, "laser", {}, {}};
  laser.samples.push_back({kSecond_ns, {-1.57, 3.14159265 / 180, 80}, {0.5f, 12.0f, 81.0f, 81.0f}});
  const auto series = RunInspect({}, {laser, {SignalKind::kScan, "rear", {}, {}}}, {});
  EXPECT_EQ(series.at(0).details,
            "4 to 4 beams, 1 to 1 deg apart, 0.5 to 12 m, 50.0 % hit nothing");
  EXPECT_EQ(series.at(1).count, 0u);
}

}  // namespace nightmap::inspect_test
