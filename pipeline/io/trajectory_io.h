// SPDX-License-Identifier: Apache-2.0
// Trajectories in the TUM format, as evo reads them: `time_s tx ty tz qx qy qz qw`, metres, unit
// quaternion, target_from_camera; `#` starts a comment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// Unit of the times in a file. Its value is the power of ten of nanoseconds in it.
enum class TimeUnit { kNs = 0, kUs = 3, kMs = 6, kS = 9 };

// Exact to the nanosecond: "1305031102.175304" <-> 1305031102175304000. ParseTime throws DataError.
std::string TimeToString(std::int64_t time_ns);
std::int64_t ParseTime_ns(std::string_view text, TimeUnit unit = TimeUnit::kS);

// `comment` is the first line; state the frames that the poses relate. Nine decimals are
// nanometres; use more for a file that is input of further computation.
std::string TrajectoryToTum(const std::vector<StampedPose>& poses,
                            const std::string& comment,
                            int num_decimals = 9);
// Throws DataError naming file and line on a wrong column count, NaN, a quaternion whose length is
// not 1 (within 5 %, then normalized), or times that do not increase.
std::vector<StampedPose> ReadTum(const std::filesystem::path& path, TimeUnit unit = TimeUnit::kS);
// Likewise of a trajectory that a stage made, which holds a pose; DataError when it holds none.
std::vector<StampedPose> ReadPoses(const std::filesystem::path& path);

// Index of the pose with exactly this time, or -1. `poses` sorted by time.
int FindPose(const std::vector<StampedPose>& poses, std::int64_t time_ns);
// The pose at exactly that time, or interpolated between neighbours at most max_gap_ns apart
// (rotation by slerp). `poses` sorted by time.
std::optional<Rigid3> PoseAt(const std::vector<StampedPose>& poses,
                             std::int64_t time_ns,
                             std::int64_t max_gap_ns);

}  // namespace nightmap
