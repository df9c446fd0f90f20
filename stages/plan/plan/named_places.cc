// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/named_places.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <iterator>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

using Path = std::filesystem::path;

constexpr std::size_t kMaxNames = 5;

std::string FewPaths(const std::vector<const QueryResult*>& queries) {
  std::vector<std::string> names;
  for (const QueryResult* query : queries) names.push_back(query->color_path);
  return FewNames(names);
}

std::vector<const QueryResult*> Select(const std::vector<QueryResult>& queries,
                                       const std::function<bool(const std::string&)>& fits) {
  std::vector<const QueryResult*> selected;
  for (const QueryResult& query : queries) {
    if (fits(query.color_path)) selected.push_back(&query);
  }
  return selected;
}

// The part of a path that does not depend on the current folder: all after the leading `..`.
std::string Tail(const std::string& name) {
  Path tail;
  for (const Path& part : Path(name).lexically_normal().relative_path()) {
    if (!tail.empty() || part != "..") tail /= part;
  }
  return tail.generic_string();
}

std::vector<const QueryResult*> Matching(const std::vector<QueryResult>& queries,
                                         const std::string& name) {
  const std::string tail = "/" + Tail(name);
  const std::array<std::function<bool(const std::string&)>, 3> rules = {
      [&](const std::string& path) { return path == name; },
      [&](const std::string& path) { return ("/" + path).ends_with(tail); },
      [&](const std::string& path) { return Path(path).stem() == name; }};
  for (const auto& rule : rules) {
    auto selected = Select(queries, rule);
    if (!selected.empty()) return selected;
  }
  return {};
}

// How many first letters two names share.
std::ptrdiff_t NumShared(const std::string& a, const std::string& b) {
  return std::ranges::mismatch(a, b).in1 - a.begin();
}

// The names, those that begin most like `name` first.
std::vector<std::string> MostAlike(const std::string& name, std::vector<std::string> names) {
  std::ranges::stable_sort(
      names, std::greater(), [&](const std::string& other) { return NumShared(name, other); });
  return names;
}

// Objects before things.
std::vector<NamedBox> AllBoxes(const std::vector<MapObject>& objects,
                               const std::vector<Thing>& things) {
  std::vector<NamedBox> boxes;
  for (const MapObject& object : objects) {
    const EndBox box{object.name, object.map_from_object, object.size_m, false};
    boxes.push_back({box, {}, {}});
  }
  for (const Thing& thing : things) {
    const EndBox box{thing.name, thing.map_from_thing, thing.size_m.head<2>(), true};
    boxes.push_back({box, thing.class_name, thing.bottom_m});
  }
  return boxes;
}

// Names what is spelt most alike.
[[noreturn]] void FailUnknownName(const std::vector<NamedBox>& boxes, const std::string& name) {
  if (boxes.empty()) {
    throw DataError(
        "object '{}': the map has no objects: name a file of them as `objects` of [import] in the "
        "site config, let make report propose some in a laser map, or take a profile that finds "
        "things",
        name);
  }
  std::vector<std::string> names;
  std::vector<std::string> classes;
  for (const auto& [box, class_name, bottom_m] : boxes) {
    names.push_back(box.name);
    if (class_name.empty() || std::ranges::count(classes, class_name) > 0) continue;
    classes.push_back(class_name);
  }
  const std::string known =
      fmt::format("the {} of the map ({})", names.size(), FewNames(MostAlike(name, names)));
  if (classes.empty()) throw DataError("object '{}' is not among {}", name, known);
  throw DataError("object '{}' is not among {}, nor a class of things ({})",
                  name,
                  known,
                  FewNames(MostAlike(name, classes)));
}

}  // namespace

std::string FewNames(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxNames); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return text + (names.size() > kMaxNames ? ", ..." : "");
}

const QueryResult& FindQuery(const std::vector<QueryResult>& queries,
                             const std::string& kind,
                             const std::string& name) {
  const auto matching = Matching(queries, name);
  if (matching.empty()) {
    const auto all = Select(queries, [](const std::string&) { return true; });
    throw DataError("{} '{}' is not among the {} localized queries ({})",
                    kind,
                    name,
                    queries.size(),
                    FewPaths(all));
  }
  if (matching.size() > 1) {
    throw DataError("{} '{}' fits {} queries ({}): give the whole path",
                    kind,
                    name,
                    matching.size(),
                    FewPaths(matching));
  }
  if (!matching[0]->IsLocated()) {
    throw DataError("{} '{}' was not located: {} ({})",
                    kind,
                    name,
                    QueryVerdictText(matching[0]->verdict),
                    matching[0]->reason);
  }
  return *matching[0];
}

std::vector<NamedBox> FindBoxes(const std::vector<MapObject>& objects,
                                const std::vector<Thing>& things,
                                const std::string& name) {
  const auto boxes = AllBoxes(objects, things);
  const auto named = std::ranges::find(boxes, name, [](const auto& box) { return box.box.name; });
  std::vector<NamedBox> found;
  std::ranges::copy_if(boxes, std::back_inserter(found), [&](const NamedBox& box) {
    return named != boxes.end() ? &box == &*named : box.class_name == name;
  });
  if (found.empty()) FailUnknownName(boxes, name);
  return found;
}

}  // namespace nightmap
