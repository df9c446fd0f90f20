// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/picture_ends.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

using Path = std::filesystem::path;

constexpr std::size_t kMaxNames = 5;

std::string FewNames(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxNames); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return text + (names.size() > kMaxNames ? ", ..." : "");
}

std::string FewNames(const std::vector<const QueryResult*>& queries) {
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

}  // namespace

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
                    FewNames(all));
  }
  if (matching.size() > 1) {
    throw DataError("{} '{}' fits {} queries ({}): give the whole path",
                    kind,
                    name,
                    matching.size(),
                    FewNames(matching));
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

const MapObject& FindObject(const std::vector<MapObject>& objects, const std::string& name) {
  const auto found = std::ranges::find(objects, name, &MapObject::name);
  if (found != objects.end()) return *found;
  if (objects.empty()) {
    throw DataError(
        "object '{}': the map has no objects: name a file of them as `objects` of [import] in the "
        "site config, or let make report propose some",
        name);
  }
  std::vector<std::string> names;
  for (const MapObject& object : objects) names.push_back(object.name);
  throw DataError(
      "object '{}' is not among the {} of the map ({})", name, names.size(), FewNames(names));
}

}  // namespace nightmap
