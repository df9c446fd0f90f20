// SPDX-License-Identifier: Apache-2.0
// The kinds of sensors beside the cameras, a row each: names, files, values.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

enum class SignalKind { kAcceleration, kOdometry, kScan };

// One of the three values of a sample.
struct SignalValue {
  std::string name;
  std::string unit;
};

struct SignalKindRow {
  SignalKind kind;
  std::string name;  // `kind` of a [[sensor]]
  std::string file;  // of all its sensors; an output of `frames`, configs/recording/pipeline.toml
  std::array<SignalValue, 3> values;
  // The largest median step of times that are taken as seconds (time_unit.h).
  double max_step_s;
  // Times that go back a little are put right, with those of other kinds (line_clock.h).
  bool has_line_clock = false;
  // The largest value, and words for one, of kinds whose lines hold the three values as they are.
  // Other kinds have a parser of their own (parse_signal_lines.cc).
  double max_value = 0;
  std::string a_value = {};
};

const std::vector<SignalKindRow>& SignalKinds();
// Throws std::logic_error on a kind without a row.
const SignalKindRow& RowOf(SignalKind kind);
// "acceleration", "odometry", "scan".
inline const std::string& NameOf(SignalKind kind) { return RowOf(kind).name; }
std::optional<SignalKind> KindOf(std::string_view name);

}  // namespace nightmap
