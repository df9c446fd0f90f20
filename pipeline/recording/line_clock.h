// SPDX-License-Identifier: Apache-2.0
// Times of the lines of a log whose clock jumps.
//
// Lines are written one after the other, so their order is certain and their stamps are not. Where
// the stamps of one kind of lines go back, as many lines as possible keep the time that they state,
// of all kinds; the others are spread evenly between these, no farther apart than lines usually
// are. Where as many could stay, those that state the later times do: a stamp that goes back is
// the wrong one. One line has one time, whoever reads it, so scans and odometry of one log stay
// together. Kinds that only lie apart, each in order, stay as they are.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace nightmap {

// From so far back on, a time is of another recording.
inline constexpr std::int64_t kMaxStepBack_ns = 3'000'000'000;

struct StampedLine {
  int line = 0;
  int kind = 0;  // lines of one kind are samples of one thing
  std::int64_t stated_ns = 0;
};

class LineClock {
 public:
  // The lines may come in any order, and more than once. A line that states the time of the line of
  // its kind before says the same again, time 0 is none, and one that is kMaxStepBack_ns before an
  // earlier one of its kind is of another recording: these have no time.
  explicit LineClock(std::vector<StampedLine> lines);

  // The time of a line; none where it has none. Times increase with the lines of a kind.
  std::optional<std::int64_t> TimeOf_ns(int line) const;

 private:
  std::vector<StampedLine> lines_;  // that have a time
  std::vector<std::int64_t> times_ns_;
};

}  // namespace nightmap
