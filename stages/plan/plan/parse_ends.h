// SPDX-License-Identifier: Apache-2.0
// Parses the options `start` and `goal`.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/queries_io.h"
#include "pipeline/io/things_io.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/plan/objects_io.h"
#include "stages/plan/plan/end_box.h"

namespace nightmap {

struct EndpointRequest {
  std::string role;  // "start", "goal" or "goal 2", for messages
  std::string text;  // "x_m,y_m", "x_m,y_m,z_m", "picture:NAME", "scan:NAME" or "object:NAME"
  // A 3-D position is projected along z.
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  std::optional<double> z_m;  // as requested, or of the camera, the robot or the thing's bottom
  bool is_picture = false;    // or a pose of the trajectory, where a camera was
  std::optional<EndBox> box = {};  // of an object or a thing; the point is its centre
};

// Choices for an end: one request, or one for each thing of a class, of which the nearest counts.
using EndChoices = std::vector<EndpointRequest>;

// Places that ends can be named after.
struct NamedPlaces {
  const std::vector<QueryResult>& queries;
  const std::vector<StampedPose>& trajectory;
  const std::vector<MapObject>& objects;
  const std::vector<Thing>& things;
};

// "goal 'object:sofa_2'", or for a thing of a class "goal 'object:sofa' (sofa_2)"; for messages.
std::string EndText(const EndpointRequest& request);

// The start and one or more goals, in order. `goals` are separated by semicolons. An empty start is
// the first located picture, and an empty list of goals the last one; where none is located, the
// first and the last pose of the trajectory. Throws UsageError on text of no such form or when
// there is no default, DataError when a query, an object or a thing is unusable (FindQuery,
// FindBoxes) or the start is a class of several things. The start has one choice.
std::vector<EndChoices> MakeRequests(const std::string& start,
                                     const std::string& goals,
                                     const NamedPlaces& places);

// Index in `floors` of the one floor that all ends are on: the start's, and at least one choice of
// each goal. A request with a z is on the highest floor that is not above it (by more than
// rounding; the lowest floor when none is). A request without a z is on the floor numbered
// `floor_number`. Throws UsageError when no floor has that number. Throws DataError when ends are
// on different floors, since no data tells where a robot could change floors, and when a z that is
// neither a camera's nor a thing's is not on a floor.
std::size_t ChooseFloor(const std::vector<EndChoices>& ends,
                        const std::vector<FloorFiles>& floors,
                        int floor_number);

// Ends with several choices keep only those on a floor, which is one that ChooseFloor returned.
std::vector<EndChoices> KeepOnFloor(std::vector<EndChoices> ends,
                                    const std::vector<FloorFiles>& floors,
                                    std::size_t floor_idx);

}  // namespace nightmap
