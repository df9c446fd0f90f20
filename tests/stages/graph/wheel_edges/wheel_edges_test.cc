// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/wheel_edges/wheel_edges.h"

#include "tests/test_data.h"

namespace nightmap::wheel_edges_test {

// Ten frames at 10 Hz, the last five of another recording; two sensors that count on all the time.
WheelEdgesInput MakeInput() {
  WheelEdgesInput input;
  for (int i = 0; i < 10; ++i) {
    input.frames.push_back({i, 100'000'000LL * i, 0, i / 5, {}, {}, {}});
  }
  input.cameras.resize(1);
  for (const auto& [id, step_m] : {std::pair("left", 0.1), std::pair("right", 0.2)}) {
    Signal& wheels = input.odometry.emplace_back();
    wheels.kind = SignalKind::kOdometry;
    wheels.sensor_id = id;
    for (int i = 0; i < 8; ++i) {
      wheels.samples.push_back({100'000'000LL * i, {step_m * i, 0, 0}, {}});
    }
  }
  return input;
}

TEST(WheelEdgesStage, TakesTheSensorThatIsNamedOrTheOnlyOne) {
  WheelEdgesInput input = MakeInput();
  const auto step_m = [&](const std::string& sensor) {
    const WheelEdgesResult result = RunWheelEdges({sensor, {}}, input);
    EXPECT_EQ(result.edges.edges.size(), 6U);  // the samples end at the eighth frame
    EXPECT_EQ(result.num_motions, 8);
    return -result.edges.edges.front().target_from_source.translation.x();
  };
  EXPECT_NEAR(step_m("left"), 0.1, 1e-12);
  EXPECT_NEAR(step_m("right"), 0.2, 1e-12);
  input.odometry.erase(input.odometry.begin());
  EXPECT_NEAR(step_m(""), 0.2, 1e-12);
}

TEST(WheelEdgesStage, AChoiceThatIsNoneNamesTheSensors) {
  for (const std::string sensor : {"", "front"}) {
    NIGHTMAP_EXPECT_ERROR(
        UsageError, RunWheelEdges({sensor, {}}, MakeInput()), "measure odometry: left, right");
  }
}

TEST(WheelEdgesStage, WithoutOdometryOrTimesInCommonTheRemedyIsNamed) {
  WheelEdgesInput input = MakeInput();
  for (FrameRecord& frame : input.frames) frame.time_ns += 1'000'000'000'000;
  NIGHTMAP_EXPECT_ERROR(DataError, RunWheelEdges({"left", {}}, input), "time_offset_s");
  input.odometry.clear();
  NIGHTMAP_EXPECT_ERROR(DataError, RunWheelEdges({}, input), "add a [[sensor]]");
}

}  // namespace nightmap::wheel_edges_test
