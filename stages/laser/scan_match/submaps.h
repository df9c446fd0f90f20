// SPDX-License-Identifier: Apache-2.0
// The recent keyscans as likelihood fields.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/laser/field_pyramid.h"

namespace nightmap {

struct Submap {
  Rigid2 start_from_submap;  // of its first keyscan
  LikelihoodField field;
  int num_keyscans = 0;
  std::optional<FieldPyramid> pyramid;  // of the field as it is; none: not made yet
};

// Two submaps at most, the newer one begun when the older one is half full. The older one goes when
// it is full.
class Submaps {
 public:
  Submaps(const LikelihoodFieldOptions& options, int num_keyscans)
      : options_(options), num_keyscans_(num_keyscans) {}

  bool IsEmpty() const { return submaps_.empty(); }
  // The one to match with, and its pyramid.
  const Submap& Older() const { return submaps_.front(); }
  const FieldPyramid& PyramidOfOlder();
  void Clear() { submaps_.clear(); }
  void Add(const Rigid2& start_from_robot, const std::vector<Eigen::Vector2d>& points_in_robot);

 private:
  LikelihoodFieldOptions options_;
  int num_keyscans_;
  std::deque<Submap> submaps_;
};

}  // namespace nightmap
