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
  std::string text;  // "x_m,y_m", "x_m,y_m,z_m" or "picture:NAME"
  // A position in space is projected along z.
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  std::optional<double> z_m;  // as asked for, or of the camera
  bool is_picture = false;    // or a pose of the trajectory: where a camera was
};

// The start and one goal or more, in order. `goals` are separated by semicolons. An empty start is
// the first located picture, an empty list of goals the last one; where none is located, the first
// and the last pose of the trajectory. Throws UsageError on text of neither form or when there is
// no default, DataError when a picture is of no use (FindPicture).
std::vector<EndpointRequest> MakeRequests(const std::string& start,
                                          const std::string& goals,
                                          const std::vector<QueryResult>& queries,
                                          const std::vector<StampedPose>& trajectory);

// Place in `floors` of the one floor that all requests are on: with a z the highest floor that is
// not above it (by more than a rounding; the lowest when none is), without one the floor of number
// `floor_number`. Throws UsageError when there is no floor of that number, DataError when requests
// are on different floors, since nothing tells where a robot could change, and when a z that is no
// camera's is not on a floor.
std::size_t ChooseFloor(const std::vector<EndpointRequest>& requests,
                        const std::vector<FloorFiles>& floors,
                        int floor_number);

}  // namespace nightmap
