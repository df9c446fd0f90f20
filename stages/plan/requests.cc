// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/requests.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "stages/plan/pictures.h"

namespace nightmap {
namespace {

constexpr std::string_view kPicturePrefix = "picture:";

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
  return {role, text, camera_in_map.head<2>(), camera_in_map.z()};
}

EndpointRequest Parse(const std::string& role,
                      const std::string& option,
                      const std::string& text,
                      const std::vector<QueryResult>& queries) {
  if (text.starts_with(kPicturePrefix) && text.size() > kPicturePrefix.size()) {
    const auto& picture = FindPicture(queries, text.substr(kPicturePrefix.size()));
    return AtCamera(role, text, picture.map_from_camera.translation);
  }
  const auto comma = text.find(',');
  const auto x = ParseReal(text.substr(0, comma));
  const auto y = comma == std::string::npos ? std::nullopt : ParseReal(text.substr(comma + 1));
  if (!x || !y) {
    throw UsageError(
        "option {} is '{}': give \"x_m,y_m\" in the map frame or \"picture:NAME\"", option, text);
  }
  return {role, text, {*x, *y}, {}};
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

}  // namespace

std::vector<EndpointRequest> MakeRequests(const std::string& start,
                                          const std::string& goals,
                                          const std::vector<QueryResult>& queries,
                                          const std::vector<StampedPose>& trajectory) {
  std::vector<EndpointRequest> requests;
  requests.push_back(start.empty() ? DefaultRequest("start", queries, trajectory)
                                   : Parse("start", "start", Trim(start), queries));
  if (goals.empty()) {
    requests.push_back(DefaultRequest("goal", queries, trajectory));
    return requests;
  }
  const auto texts = SplitGoals(goals);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string role = texts.size() == 1 ? "goal" : fmt::format("goal {}", i + 1);
    requests.push_back(Parse(role, "goal", texts[i], queries));
  }
  return requests;
}

void CheckFloors(const std::vector<EndpointRequest>& requests,
                 const std::vector<FloorFiles>& floors) {
  if (floors.size() < 2) return;
  for (const EndpointRequest& request : requests) {
    if (!request.IsPicture()) continue;
    const FloorFiles& floor = floors[FloorBelow(floors, *request.camera_z_m)];
    if (floor.is_main) continue;
    throw DataError(
        "{} '{}' was taken at z = {:.2f} m, above the floor at {:.2f} m, but paths are planned on "
        "the "
        "main floor: for that floor run the plan program on {} beside map.yaml",
        request.role,
        request.text,
        *request.camera_z_m,
        floor.height_m,
        floor.yaml);
  }
}

}  // namespace nightmap
