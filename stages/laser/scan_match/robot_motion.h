// SPDX-License-Identifier: Apache-2.0
// How the robot moves from one scan to the next one, before the scan is looked at.
#pragma once

#include <cstdint>
#include <optional>

#include "pipeline/laser/match_scan.h"
#include "pipeline/recording/wheel_motion.h"
#include "stages/laser/scan_match/scan_match.h"

namespace nightmap {

// Where the robot will be, in the frame of its start, and its motion by the wheels, where they
// tell.
struct Prediction {
  PosePrior start_from_robot;
  std::optional<Rigid2> last_from_robot;
  bool is_after_pause = false;  // of more than kPause_s without scans and wheels
};
inline constexpr double kPause_s = 20;

// Knows the last two scans. Moves by the wheels, or as between those two scans.
class RobotMotion {
 public:
  // `wheels` may be null.
  RobotMotion(const ScanMatchOptions& options, const Signal* wheels)
      : options_(options), wheels_(wheels) {}

  void Add(const MatchedScan& scan);
  const std::optional<MatchedScan>& Last() const { return last_; }

  Prediction At(std::int64_t time_ns) const;
  std::optional<WheelMotion> ByWheels(std::int64_t start_ns, std::int64_t end_ns) const;
  // The motion between the last two scans, and between two others, over a time.
  Rigid2 LastMotion(double passed_s) const;
  static Rigid2 MotionOver(const MatchedScan& a, const MatchedScan& b, double passed_s);

 private:
  const ScanMatchOptions& options_;
  const Signal* wheels_;
  std::optional<MatchedScan> last_, before_last_;
};

}  // namespace nightmap
