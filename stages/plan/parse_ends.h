// SPDX-License-Identifier: Apache-2.0
// Parses the options `start` and `goal`.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/queries_io.h"
#include "pipeline/planar/floors_io.h"
#include "pipeline/planar/objects_io.h"

namespace nightmap {

struct EndpointRequest {
  std::string role;  // "start", "goal" or "goal 2", for messages
  std::string text;  // "x_m,y_m", "x_m,y_m,z_m", "picture:NAME", "scan:NAME" or "object:NAME"
  // A 3-D position is projected along z.
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  std::optional<double> z_m;  // as requested, or the camera's or the robot's
  bool is_picture = false;    // or a pose of the trajectory, where a camera was
  double half_extent_m = 0;   // half the diagonal of an object, which the robot stands beside
};

// The start and one or more goals, in order. `goals` are separated by semicolons. An empty start is
// the first located picture, and an empty list of goals the last one; where none is located, the
// first and the last pose of the trajectory. Throws UsageError on text of no such form or when
// there is no default, DataError when a query or an object is unusable (FindQuery, FindObject).
std::vector<EndpointRequest> MakeRequests(const std::string& start,
                                          const std::string& goals,
                                          const std::vector<QueryResult>& queries,
                                          const std::vector<StampedPose>& trajectory,
                                          const std::vector<MapObject>& objects);

// Index in `floors` of the one floor that all requests are on. A request with a z is on the highest
// floor that is not above it (by more than rounding; the lowest floor when none is). A request
// without a z is on the floor numbered `floor_number`. Throws UsageError when no floor has that
// number. Throws DataError when requests are on different floors, since no data tells where a robot
// could change floors, and when a z that is not a camera's is not on a floor.
std::size_t ChooseFloor(const std::vector<EndpointRequest>& requests,
                        const std::vector<FloorFiles>& floors,
                        int floor_number);

}  // namespace nightmap
