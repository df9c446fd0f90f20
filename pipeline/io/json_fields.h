// SPDX-License-Identifier: Apache-2.0
// Checked fields of JSON objects. IntegerAt and FiniteAt throw DataError naming the field, and
// nlohmann's exception when it is missing or not a number.
#pragma once

#include <cmath>
#include <exception>
#include <limits>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/memory.h"

namespace nightmap {

// nlohmann's get<int> would truncate fractions and wrap large values.
template <typename Json>
int IntegerAt(const Json& json,
              const char* name,
              int min = 0,
              int max = std::numeric_limits<int>::max()) {
  const Json& field = json.at(name);
  const auto value = field.template get<double>();
  if (!field.is_number_integer() || value < min || value > max) {
    throw DataError("{} is {}, not an integer in [{}, {}]", name, value, min, max);
  }
  return field.template get<int>();
}

template <typename Json>
double FiniteAt(const Json& json, const char* name) {
  const double value = json.at(name).template get<double>();
  if (!std::isfinite(value)) throw DataError("{} is not finite", name);
  return value;
}

// The message of an exception without the library's error number. To be called while it is caught:
// lack of memory is no damage of the file, and is thrown on.
inline std::string JsonReason(const std::exception& error) {
  if (IsOutOfMemory(error)) throw;
  const std::string text = error.what();
  const std::size_t end = text.starts_with("[json.exception") ? text.find("] ") : std::string::npos;
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace nightmap
