// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/parse_ends.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "stages/plan/picture_ends.h"

namespace nightmap {
namespace {

constexpr std::string_view kPicturePrefix = "picture:";
constexpr std::string_view kScanPrefix = "scan:";
constexpr std::string_view kObjectPrefix = "object:";
constexpr double kMaxBelowFloor_m = 0.1;  // tolerance for rounded heights of floors
constexpr double kMaxAboveFloor_m = 2.5;  // the grid stage's limit for cameras

std::string Trim(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

std::vector<std::string> SplitGoals(const std::string& text) {
  std::vector<std::string> goals;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(';', begin);
    goals.push_back(Trim(text.substr(begin, end - begin)));
    if (end == std::string::npos) return goals;
    begin = end + 1;
  }
}

EndpointRequest AtCamera(const std::string& role,
                         const std::string& text,
                         const Eigen::Vector3d& camera_in_map) {
  return {role, text, camera_in_map.head<2>(), camera_in_map.z(), true};
}

// What follows the prefix; empty when the text does not begin with it.
std::string NameAfter(std::string_view prefix, const std::string& text) {
  return text.starts_with(prefix) ? text.substr(prefix.size()) : "";
}

// Nobody stands in a column, so the end moves to a place around it.
EndpointRequest AtObject(const std::string& role,
                         const std::string& text,
                         const MapObject& object) {
  EndpointRequest request{role, text, object.map_from_object.translation, {}};
  request.half_extent_m = object.size_m.norm() / 2;
  return request;
}

// Parses two or three numbers; otherwise returns none.
std::vector<double> ParseNumbers(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto number = ParseReal(text.substr(begin, end - begin));
    if (!number) return {};
    numbers.push_back(*number);
    begin = end + 1;
  }
  return numbers.size() == 2 || numbers.size() == 3 ? numbers : std::vector<double>();
}

EndpointRequest Parse(const std::string& role,
                      const std::string& option,
                      const std::string& text,
                      const std::vector<QueryResult>& queries,
                      const std::vector<MapObject>& objects) {
  if (const auto name = NameAfter(kPicturePrefix, text); !name.empty()) {
    return AtCamera(role, text, FindQuery(queries, "picture", name).map_from_camera.translation);
  }
  if (const auto name = NameAfter(kScanPrefix, text); !name.empty()) {
    const auto& robot_in_map = FindQuery(queries, "scan", name).map_from_camera.translation;
    return {role, text, robot_in_map.head<2>(), robot_in_map.z()};
  }
  if (const auto name = NameAfter(kObjectPrefix, text); !name.empty()) {
    return AtObject(role, text, FindObject(objects, name));
  }
  const auto numbers = ParseNumbers(text);
  if (numbers.empty()) {
    throw UsageError(
        "option {} is '{}': give \"x_m,y_m\" or \"x_m,y_m,z_m\" in the map frame, "
        "\"picture:NAME\", \"scan:NAME\" or \"object:NAME\"",
        option,
        text);
  }
  EndpointRequest request{role, text, {numbers[0], numbers[1]}, {}};
  if (numbers.size() == 3) request.z_m = numbers[2];
  return request;
}

EndpointRequest DefaultRequest(const std::string& role,
                               const std::vector<QueryResult>& queries,
                               const std::vector<StampedPose>& trajectory) {
  const bool first = role == "start";
  std::vector<const QueryResult*> located;
  for (const auto& query : queries) {
    if (query.IsLocated()) located.push_back(&query);
  }
  if (!located.empty()) {
    const QueryResult& picture = first ? *located.front() : *located.back();
    return AtCamera(role,
                    std::string(kPicturePrefix) + picture.color_path,
                    picture.map_from_camera.translation);
  }
  if (!trajectory.empty()) {
    const StampedPose& pose = first ? trajectory.front() : trajectory.back();
    const Eigen::Vector3d& position = pose.pose.translation;
    return AtCamera(
        role, fmt::format("trajectory at {:.3f},{:.3f}", position.x(), position.y()), position);
  }
  throw UsageError(
      "option {} is empty and there is no located query: set plan.{} = \"x_m,y_m\"", role, role);
}

std::size_t FloorOf(const EndpointRequest& request,
                    const std::vector<FloorFiles>& floors,
                    int floor_number) {
  if (!request.z_m) {
    const auto found = FindFloor(floors, floor_number);
    if (found) return *found;
    throw UsageError("option floor is {}, but the map has {}", floor_number, FloorsText(floors));
  }
  const std::size_t below = FloorBelow(floors, *request.z_m + kMaxBelowFloor_m);
  const double above_m = *request.z_m - floors[below].height_m;
  if (!request.is_picture && (above_m < -kMaxBelowFloor_m || above_m > kMaxAboveFloor_m)) {
    throw DataError("{} '{}' is {:.2f} m above {}: it is on no floor, the map has {}",
                    request.role,
                    request.text,
                    above_m,
                    FloorText(floors[below]),
                    FloorsText(floors));
  }
  return below;
}

}  // namespace

std::vector<EndpointRequest> MakeRequests(const std::string& start,
                                          const std::string& goals,
                                          const std::vector<QueryResult>& queries,
                                          const std::vector<StampedPose>& trajectory,
                                          const std::vector<MapObject>& objects) {
  std::vector<EndpointRequest> requests;
  requests.push_back(start.empty() ? DefaultRequest("start", queries, trajectory)
                                   : Parse("start", "start", Trim(start), queries, objects));
  if (goals.empty()) {
    requests.push_back(DefaultRequest("goal", queries, trajectory));
    return requests;
  }
  const auto texts = SplitGoals(goals);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string role = texts.size() == 1 ? "goal" : fmt::format("goal {}", i + 1);
    requests.push_back(Parse(role, "goal", texts[i], queries, objects));
  }
  return requests;
}

std::size_t ChooseFloor(const std::vector<EndpointRequest>& requests,
                        const std::vector<FloorFiles>& floors,
                        int floor_number) {
  const std::size_t chosen = FloorOf(requests[0], floors, floor_number);
  for (const EndpointRequest& request : requests) {
    const std::size_t other = FloorOf(request, floors, floor_number);
    if (other == chosen) continue;
    throw DataError(
        "{} '{}' is on {}, but {} '{}' on {}: a path keeps to one floor, since the map has no "
        "stairs or lifts; \"x_m,y_m\" is on floor {}, as the option floor says",
        requests[0].role,
        requests[0].text,
        FloorText(floors[chosen]),
        request.role,
        request.text,
        FloorText(floors[other]),
        floor_number);
  }
  return chosen;
}

}  // namespace nightmap
