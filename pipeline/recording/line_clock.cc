// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/line_clock.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

#include "pipeline/base/median.h"

namespace nightmap {
namespace {

using Lines = std::vector<StampedLine>;

constexpr std::size_t kLinesOfStep = 32;  // a step is measured over so many, for stamps of batches

constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max() / 2;

// Lines `begin` to before `end`.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// Those that have a time, in order.
Lines WithTime(Lines lines) {
  std::ranges::sort(lines, {}, [](const StampedLine& l) { return std::tuple(l.line, l.kind); });
  const auto is_same = [](const StampedLine& a, const StampedLine& b) { return a.line == b.line; };
  lines.erase(std::unique(lines.begin(), lines.end(), is_same), lines.end());
  struct Before {
    std::int64_t stated_ns;
    std::int64_t latest_ns;
  };
  std::map<int, Before> of_kind;
  std::erase_if(lines, [&](const StampedLine& line) {
    const auto before = of_kind.find(line.kind);
    if (before == of_kind.end()) {
      of_kind[line.kind] = {line.stated_ns, line.stated_ns};
      return false;
    }
    auto& [stated_ns, latest_ns] = before->second;
    if (line.stated_ns == stated_ns || line.stated_ns == 0 ||
        line.stated_ns <= latest_ns - kMaxStepBack_ns) {
      return true;
    }
    stated_ns = line.stated_ns;
    latest_ns = std::max(latest_ns, stated_ns);
    return false;
  });
  return lines;
}

// The shortest stretches within which times of a kind go back, so that all lines of the kind before
// a stretch are earlier and all after it later; in order and apart.
std::vector<Stretch> StretchesOutOfOrder(const Lines& lines) {
  struct OfKind {
    std::vector<std::size_t> idxs;
    std::vector<std::int64_t> latest_ns;  // up to each of them
  };
  std::map<int, OfKind> kinds;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    auto& [idxs, latest_ns] = kinds[lines[i].kind];
    const std::int64_t time_ns = lines[i].stated_ns;
    idxs.push_back(i);
    latest_ns.push_back(latest_ns.empty() ? time_ns : std::max(latest_ns.back(), time_ns));
  }
  std::vector<Stretch> found;
  for (const auto& [kind, of_kind] : kinds) {
    const auto& [idxs, latest_ns] = of_kind;
    std::int64_t earliest_ns = std::numeric_limits<std::int64_t>::max();  // of those after
    std::size_t end = idxs.size();
    for (std::size_t i = idxs.size(); i-- > 0;) {
      earliest_ns = std::min(earliest_ns, lines[idxs[i]].stated_ns);
      if (i > 0 && latest_ns[i - 1] >= earliest_ns) continue;
      if (end - i > 1) found.push_back({idxs[i], idxs[end - 1] + 1});
      end = i;
    }
  }
  std::ranges::sort(found, {}, &Stretch::begin);
  std::vector<Stretch> apart;
  for (const Stretch& stretch : found) {
    if (apart.empty() || stretch.begin > apart.back().end) {
      apart.push_back(stretch);
    } else {
      apart.back().end = std::max(apart.back().end, stretch.end);
    }
  }
  return apart;
}

// The usual time from line to line.
std::int64_t Step_ns(const Lines& lines) {
  if (lines.size() < 2) return 1;
  const std::size_t count = std::min(kLinesOfStep, lines.size() - 1);
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = count; i < lines.size(); ++i) {
    steps_ns.push_back((lines[i].stated_ns - lines[i - count].stated_ns) /
                       static_cast<std::int64_t>(count));
  }
  return std::max<std::int64_t>(Median(steps_ns), 1);
}

// Puts the stretches of lines right, in their order.
class Mender {
 public:
  explicit Mender(const Lines& lines)
      : lines_(lines), step_ns_(Step_ns(lines)), latest_ns_{-1}, earliest_ns_(lines.size() + 1) {
    for (const StampedLine& line : lines) times_ns_.push_back(line.stated_ns);
    earliest_ns_.back() = kNever_ns;
    for (std::size_t i = lines.size(); i-- > 0;) {
      earliest_ns_[i] = std::min(earliest_ns_[i + 1], lines[i].stated_ns);
    }
  }

  void Mend(Stretch stretch) {
    stretch.begin = std::max(stretch.begin, mended_);
    if (stretch.begin >= stretch.end) return;
    while (latest_ns_.size() <= stretch.begin) {
      latest_ns_.push_back(std::max(latest_ns_.back(), times_ns_[latest_ns_.size() - 1]));
    }
    // Where kinds lie apart, the lines around may leave those of the stretch no time.
    while (After_ns(stretch) - Before_ns(stretch) <= Count(stretch)) {
      if (stretch.begin > mended_) --stretch.begin;
      if (stretch.end < lines_.size()) ++stretch.end;
    }
    latest_ns_.resize(stretch.begin + 1);
    std::size_t next = stretch.begin;
    std::int64_t before_ns = Before_ns(stretch);
    for (const std::size_t kept : Keep(stretch)) {
      before_ns = Spread({next, kept}, before_ns, lines_[kept].stated_ns);
      next = kept + 1;
    }
    Spread({next, stretch.end}, before_ns, After_ns(stretch));
    mended_ = stretch.end;
  }

  std::vector<std::int64_t> TakeTimes_ns() { return std::move(times_ns_); }

 private:
  static std::int64_t Count(const Stretch& stretch) {
    return static_cast<std::int64_t>(stretch.end - stretch.begin);
  }

  std::int64_t Before_ns(const Stretch& stretch) const { return latest_ns_[stretch.begin]; }
  std::int64_t After_ns(const Stretch& stretch) const { return earliest_ns_[stretch.end]; }

  // The most lines whose times ascend and leave each line between a nanosecond. Rows of lines are
  // sought from the end, so that the latest times win.
  std::vector<std::size_t> Keep(const Stretch& stretch) const {
    const auto ascending_ns = [&](std::size_t i) {
      return lines_[i].stated_ns - static_cast<std::int64_t>(i - stretch.begin);
    };
    std::vector<std::size_t> starts;  // of a row of 1, 2, ... lines, the latest one
    std::vector<std::size_t> next(stretch.end - stretch.begin);
    for (std::size_t i = stretch.end; i-- > stretch.begin;) {
      const std::int64_t start_ns = ascending_ns(i);
      if (start_ns <= Before_ns(stretch) || start_ns > After_ns(stretch) - Count(stretch)) continue;
      const auto place = std::ranges::partition_point(
          starts, [&](std::size_t start) { return ascending_ns(start) >= start_ns; });
      next[i - stretch.begin] = place == starts.begin() ? stretch.end : *std::prev(place);
      if (place == starts.end()) {
        starts.push_back(i);
      } else {
        *place = i;
      }
    }
    std::vector<std::size_t> kept;
    for (std::size_t i = starts.empty() ? stretch.end : starts.back(); i < stretch.end;) {
      kept.push_back(i);
      i = next[i - stretch.begin];
    }
    return kept;
  }

  // Spreads lines evenly between two times, no farther apart than usual. Returns the latter.
  std::int64_t Spread(const Stretch& stretch, std::int64_t before_ns, std::int64_t after_ns) {
    const std::int64_t num_steps = Count(stretch) + 1;
    if (stretch.begin == 0) before_ns = std::max(before_ns, after_ns - num_steps * step_ns_);
    const std::int64_t step_ns = std::min(step_ns_, (after_ns - before_ns) / num_steps);
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) times_ns_[i] = before_ns += step_ns;
    return after_ns;
  }

  const Lines& lines_;
  std::int64_t step_ns_;
  std::size_t mended_ = 0;                 // lines up to here
  std::vector<std::int64_t> times_ns_;     // of lines, as far as mended
  std::vector<std::int64_t> latest_ns_;    // before each line, so far
  std::vector<std::int64_t> earliest_ns_;  // stated from each line on
};

// Whether kinds have clocks that have nothing to do with each other.
bool AreOfSeveralClocks(const Lines& lines) {
  const auto is_other = [&](const StampedLine& line) { return line.kind != lines.front().kind; };
  std::int64_t latest_ns = lines.front().stated_ns;
  return std::ranges::any_of(lines, is_other) &&
         std::ranges::any_of(lines, [&](const StampedLine& line) {
           latest_ns = std::max(latest_ns, line.stated_ns);
           return line.stated_ns <= latest_ns - kMaxStepBack_ns;
         });
}

}  // namespace

LineClock::LineClock(std::vector<StampedLine> lines) : lines_(WithTime(std::move(lines))) {
  if (lines_.empty()) return;
  if (AreOfSeveralClocks(lines_)) {
    std::map<int, Lines> kinds;
    for (const StampedLine& line : lines_) kinds[line.kind].push_back(line);
    std::map<int, LineClock> clocks;
    for (const auto& [kind, of_kind] : kinds) clocks.emplace(kind, of_kind);
    for (const StampedLine& line : lines_) {
      times_ns_.push_back(*clocks.at(line.kind).TimeOf_ns(line.line));
    }
    return;
  }
  Mender mender(lines_);
  for (const Stretch& stretch : StretchesOutOfOrder(lines_)) mender.Mend(stretch);
  times_ns_ = mender.TakeTimes_ns();
}

std::optional<std::int64_t> LineClock::TimeOf_ns(int line) const {
  const auto found = std::ranges::lower_bound(lines_, line, {}, &StampedLine::line);
  if (found == lines_.end() || found->line != line) return std::nullopt;
  return times_ns_[static_cast<std::size_t>(found - lines_.begin())];
}

}  // namespace nightmap
