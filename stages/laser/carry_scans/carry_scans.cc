// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/carry_scans/carry_scans.h"

#include <map>

#include "pipeline/base/input_error.h"
#include "pipeline/graph/frame_poses.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

// graph_from_robot by index of the scan.
std::map<int, Rigid3> Known(const CarryScansInput& input) {
  std::map<int, Rigid3> known;
  for (const StampedPose& keyscan : input.keyscans) {
    const int idx = FindPose(input.scans, keyscan.time_ns);
    if (idx < 0) {
      throw InputError({{"keyframes"}, {"scans"}},
                       "there is a keyscan and no scan at {} s",
                       TimeToString(keyscan.time_ns));
    }
    known.emplace(idx, keyscan.pose);
  }
  if (known.empty()) throw InputError({{"keyframes"}}, "holds no keyscan");
  return known;
}

}  // namespace

std::vector<StampedPose> RunCarryScans(const CarryScansInput& input) {
  OdometryChain chain;
  for (const StampedPose& scan : input.scans) chain.graph_from_camera.push_back(scan.pose);
  const std::vector<Rigid3> map_from_robot = CarryFrames(chain, Known(input));
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < input.scans.size(); ++i) {
    poses.push_back({input.scans[i].time_ns, map_from_robot[i]});
  }
  return poses;
}

}  // namespace nightmap
