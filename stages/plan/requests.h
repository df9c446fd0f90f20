// SPDX-License-Identifier: Apache-2.0
// What the options `start` and `goal` ask for.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/floors_io.h"
#include "pipeline/io/queries_io.h"

namespace nightmap {

struct EndpointRequest {
  std::string role;  // "start", "goal" or "goal 2", for messages
  std::string text;  // "x_m,y_m" or "picture:NAME"
  // A camera's position is projected along z.
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  std::optional<double> camera_z_m;  // of a picture

  bool IsPicture() const { return camera_z_m.has_value(); }
};

// The start and one goal or more, in order. `goals` are separated by semicolons. An empty start is
// the first located picture, an empty list of goals the last one; where none is located, the first
// and the last pose of the trajectory. Throws UsageError on text of neither form or when there is
// no default, DataError when a picture is of no use (FindPicture).
std::vector<EndpointRequest> MakeRequests(const std::string& start,
                                          const std::string& goals,
                                          const std::vector<QueryResult>& queries,
                                          const std::vector<StampedPose>& trajectory);

// The grid is that of the main floor. Throws DataError when a picture was taken on another one.
void CheckFloors(const std::vector<EndpointRequest>& requests,
                 const std::vector<FloorFiles>& floors);

}  // namespace nightmap
