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

std::string FewNames(const std::vector<const QueryResult*>& queries) {
  std::string names;
  for (std::size_t i = 0; i < std::min(queries.size(), kMaxNames); ++i) {
    names += (i == 0 ? "" : ", ") + queries[i]->color_path;
  }
  return names + (queries.size() > kMaxNames ? ", ..." : "");
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

const QueryResult& FindPicture(const std::vector<QueryResult>& queries, const std::string& name) {
  const auto matching = Matching(queries, name);
  if (matching.empty()) {
    const auto all = Select(queries, [](const std::string&) { return true; });
    throw DataError("picture '{}' is not among the {} localized queries ({})",
                    name,
                    queries.size(),
                    FewNames(all));
  }
  if (matching.size() > 1) {
    throw DataError("picture '{}' fits {} queries ({}): give the whole path",
                    name,
                    matching.size(),
                    FewNames(matching));
  }
  if (!matching[0]->IsLocated()) {
    throw DataError("picture '{}' was not located: {} ({})",
                    name,
                    QueryVerdictText(matching[0]->verdict),
                    matching[0]->reason);
  }
  return *matching[0];
}

}  // namespace nightmap
