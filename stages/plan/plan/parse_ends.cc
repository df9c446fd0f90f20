// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/parse_ends.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "stages/plan/plan/named_places.h"

namespace nightmap {
namespace {

constexpr std::string_view kPicturePrefix = "picture:";
constexpr double kMaxBelowFloor_m = 0.1;  // tolerance for rounded heights of floors
constexpr double kMaxSunk_m = 0.1;        // of a thing's measured bottom, besides
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

// An end as asked for.
struct Asked {
  std::string role;
  std::string option;
  std::string text;
  std::string name = {};  // what follows the prefix of its kind
};

EndChoices AtPicture(const Asked& asked, const NamedPlaces& places) {
  const QueryResult& query = FindQuery(places.queries, "picture", asked.name);
  return {AtCamera(asked.role, asked.text, query.map_from_camera.translation)};
}

EndChoices AtScan(const Asked& asked, const NamedPlaces& places) {
  const QueryResult& query = FindQuery(places.queries, "scan", asked.name);
  const Eigen::Vector3d& robot_in_map = query.map_from_camera.translation;
  return {{asked.role, asked.text, robot_in_map.head<2>(), robot_in_map.z()}};
}

// Nobody stands in a column or a sofa, so the end moves to a place around it.
EndChoices AtBoxes(const Asked& asked, const NamedPlaces& places) {
  EndChoices choices;
  for (const auto& [box, class_name, bottom_m] :
       FindBoxes(places.objects, places.things, asked.name)) {
    choices.push_back({asked.role, asked.text, box.map_from_box.translation, {}, false, box});
    if (bottom_m) choices.back().z_m = *bottom_m + kMaxSunk_m;
  }
  return choices;
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

EndChoices AtPoint(const Asked& asked, const NamedPlaces&) {
  const auto numbers = ParseNumbers(asked.text);
  if (numbers.empty()) {
    throw UsageError(
        "option {} is '{}': give \"x_m,y_m\" or \"x_m,y_m,z_m\" in the map frame, "
        "\"picture:NAME\", \"scan:NAME\" or \"object:NAME\"",
        asked.option,
        asked.text);
  }
  EndpointRequest request{asked.role, asked.text, {numbers[0], numbers[1]}, {}};
  if (numbers.size() == 3) request.z_m = numbers[2];
  return {request};
}

struct EndKind {
  std::string_view prefix;
  EndChoices (*resolve)(const Asked&, const NamedPlaces&);
};
// The first whose prefix and a name make the text; a point needs neither.
constexpr EndKind kEndKinds[] = {
    {kPicturePrefix, AtPicture}, {"scan:", AtScan}, {"object:", AtBoxes}, {"", AtPoint}};

EndChoices Parse(Asked asked, const NamedPlaces& places) {
  const EndKind& kind = *std::ranges::find_if(kEndKinds, [&](const EndKind& candidate) {
    return candidate.prefix.empty() || (asked.text.starts_with(candidate.prefix) &&
                                        asked.text.size() > candidate.prefix.size());
  });
  asked.name = asked.text.substr(kind.prefix.size());
  return kind.resolve(asked, places);
}

// The nearest of a class is nearest to the end before it, and a start has none.
EndChoices ParseStart(const std::string& text, const NamedPlaces& places) {
  EndChoices choices = Parse({"start", "start", text}, places);
  if (choices.size() == 1) return choices;
  std::vector<std::string> names;
  for (const EndpointRequest& choice : choices) names.push_back(choice.box->name);
  throw DataError(
      "start '{}' fits {} things ({}): name one of them; only a goal is the nearest of its class",
      text,
      names.size(),
      FewNames(names));
}

EndpointRequest DefaultRequest(const std::string& role, const NamedPlaces& places) {
  const bool first = role == "start";
  std::vector<const QueryResult*> located;
  for (const auto& query : places.queries) {
    if (query.IsLocated()) located.push_back(&query);
  }
  if (!located.empty()) {
    const QueryResult& picture = first ? *located.front() : *located.back();
    return AtCamera(role,
                    std::string(kPicturePrefix) + picture.color_path,
                    picture.map_from_camera.translation);
  }
  if (!places.trajectory.empty()) {
    const StampedPose& pose = first ? places.trajectory.front() : places.trajectory.back();
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
  const bool was_seen = request.is_picture || request.box;
  if (!was_seen && (above_m < -kMaxBelowFloor_m || above_m > kMaxAboveFloor_m)) {
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

std::string EndText(const EndpointRequest& request) {
  const std::string text = fmt::format("{} '{}'", request.role, request.text);
  const bool is_named = !request.box || request.text.ends_with(":" + request.box->name);
  return is_named ? text : fmt::format("{} ({})", text, request.box->name);
}

std::vector<EndChoices> MakeRequests(const std::string& start,
                                     const std::string& goals,
                                     const NamedPlaces& places) {
  std::vector<EndChoices> ends;
  ends.push_back(start.empty() ? EndChoices{DefaultRequest("start", places)}
                               : ParseStart(Trim(start), places));
  if (goals.empty()) {
    ends.push_back({DefaultRequest("goal", places)});
    return ends;
  }
  const auto texts = SplitGoals(goals);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string role = texts.size() == 1 ? "goal" : fmt::format("goal {}", i + 1);
    ends.push_back(Parse({role, "goal", texts[i]}, places));
  }
  return ends;
}

std::size_t ChooseFloor(const std::vector<EndChoices>& ends,
                        const std::vector<FloorFiles>& floors,
                        int floor_number) {
  const EndpointRequest& start = ends[0][0];
  const std::size_t chosen = FloorOf(start, floors, floor_number);
  for (const EndChoices& choices : ends) {
    const bool is_on_it = std::ranges::any_of(choices, [&](const EndpointRequest& request) {
      return FloorOf(request, floors, floor_number) == chosen;
    });
    if (is_on_it) continue;
    throw DataError(
        "{} is on {}, but {} on {}: a path keeps to one floor, since the map has no "
        "stairs or lifts; \"x_m,y_m\" is on floor {}, as the option floor says",
        EndText(start),
        FloorText(floors[chosen]),
        EndText(choices[0]),
        FloorText(floors[FloorOf(choices[0], floors, floor_number)]),
        floor_number);
  }
  return chosen;
}

std::vector<EndChoices> KeepOnFloor(std::vector<EndChoices> ends,
                                    const std::vector<FloorFiles>& floors,
                                    std::size_t floor_idx) {
  for (EndChoices& choices : ends) {
    if (choices.size() == 1) continue;
    std::erase_if(choices, [&](const EndpointRequest& thing) {
      return FloorOf(thing, floors, floors[floor_idx].number) != floor_idx;
    });
  }
  return ends;
}

}  // namespace nightmap
