// SPDX-License-Identifier: Apache-2.0
// Numbers of JSON objects, checked. Throw DataError naming the field, nlohmann's exception when it
// is missing or no number.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "pipeline/base/error.h"

namespace nightmap {

// nlohmann's get<int> would cut what is too large, and a fraction.
template <typename Json>
int IntegerAt(const Json& json,
              const char* name,
              int min = 0,
              int max = std::numeric_limits<int>::max()) {
  const Json& field = json.at(name);
  const bool fits =
      field.is_number_unsigned()
          ? field.template get<std::uint64_t>() <= static_cast<std::uint64_t>(std::max(max, 0))
          : field.is_number_integer() && field.template get<std::int64_t>() <= max;
  if (!fits || field.template get<std::int64_t>() < min) {
    throw DataError("{} is {}, not an integer in [{}, {}]", name, field.dump(), min, max);
  }
  return field.template get<int>();
}

template <typename Json>
double FiniteAt(const Json& json, const char* name) {
  const double value = json.at(name).template get<double>();
  if (!std::isfinite(value)) throw DataError("{} is not finite", name);
  return value;
}

}  // namespace nightmap
