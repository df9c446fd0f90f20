// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/import_trajectory/import_trajectory.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstddef>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/frame_lists.h"

namespace nightmap {
namespace {

bool IsFar(const ImportTrajectoryOptions& options, const Rigid3& a, const Rigid3& b) {
  return (a.translation - b.translation).norm() >= options.keyframe_distance_m ||
         a.rotation.angularDistance(b.rotation) >= options.keyframe_turn_rad;
}

// Why so few frames have a pose, and the remedy.
std::string WhyFew(const std::vector<FrameRecord>& frames,
                   const std::vector<StampedPose>& given,
                   std::size_t num_posed) {
  const auto is_within = [&](const FrameRecord& frame) {
    return !given.empty() && frame.time_ns >= given.front().time_ns &&
           frame.time_ns <= given.back().time_ns;
  };
  const auto num_within = std::ranges::count_if(frames, is_within);
  if (2 * num_within < std::ssize(frames)) {
    return fmt::format(
        "only {} frames are within its times: column 1 must be times of the "
        "recording, in seconds",
        num_within);
  }
  return fmt::format(
      "{} more are between poses over 0.1 s apart, too far to interpolate: give a pose for every "
      "frame, or map the frames that have one with SET=\"import_trajectory.min_posed_ratio=0\"",
      static_cast<std::size_t>(num_within) - num_posed);
}

std::string TimesText(const std::vector<std::int64_t>& times_ns) {
  constexpr std::size_t kMaxShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(times_ns.size(), kMaxShown); ++i) {
    text += (i == 0 ? "" : ", ") + TimeToString(times_ns[i]);
  }
  return times_ns.size() > kMaxShown ? text + ", ..." : text;
}

}  // namespace

ImportedTrajectory RunImportTrajectory(const ImportTrajectoryOptions& options,
                                       const std::vector<FrameRecord>& frames,
                                       const std::vector<StampedPose>& given) {
  ImportedTrajectory result;
  for (const FrameRecord& frame : frames) {
    const auto pose = TruthAt(given, frame.time_ns);
    if (!pose) continue;
    result.poses.push_back({frame.time_ns, *pose});
    if (result.keyframes.empty() || IsFar(options, *pose, result.keyframes.back().pose)) {
      result.keyframes.push_back(result.poses.back());
    }
  }
  return result;
}

void JudgeNumPosed(const ImportTrajectoryOptions& options,
                   const std::vector<FrameRecord>& frames,
                   const std::vector<StampedPose>& given,
                   std::size_t num_posed,
                   const std::string& file) {
  const double min_posed = options.min_posed_ratio * static_cast<double>(frames.size());
  if (num_posed > 0 && static_cast<double>(num_posed) >= min_posed) return;
  throw ThresholdError("{}: gives a pose to {} of {} frames, fewer than min_posed_ratio = {}; {}",
                       file,
                       num_posed,
                       frames.size(),
                       options.min_posed_ratio,
                       WhyFew(frames, given, num_posed));
}

void JudgeMotions(const MotionVerdict& verdict, const std::string& file) {
  if (!verdict.contradiction.empty()) {
    throw DataError(
        "{}: contradicts the recording: {} (SET=\"import_trajectory.check_motion=false\" takes it "
        "as "
        "it is)",
        file,
        verdict.contradiction);
  }
  if (verdict.num_motions < kMinMotions) {
    spdlog::warn(
        "{}: only {} motions between pictures with depth can be compared with it, so that it was "
        "not checked",
        file,
        verdict.num_motions);
  }
  if (!verdict.doubt.empty()) spdlog::warn("{}: {}", file, verdict.doubt);
}

void JudgeJumps(const PoseJumps& jumps, const std::string& file) {
  if (!jumps.away_ns.empty()) {
    throw DataError(
        "{}: {} poses are out of the camera's reach, faster than 10 m/s away and back, at "
        "time_s {}: remove these lines",
        file,
        jumps.away_ns.size(),
        TimesText(jumps.away_ns));
  }
  if (!jumps.lasting_ns.empty()) {
    spdlog::warn("{}: jumps faster than 10 m/s {} times, at time_s {}: the map may be torn there",
                 file,
                 jumps.lasting_ns.size(),
                 TimesText(jumps.lasting_ns));
  }
}

}  // namespace nightmap
