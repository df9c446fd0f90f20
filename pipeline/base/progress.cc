// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace nightmap {
namespace {

using Seconds = std::chrono::duration<double>;
constexpr Seconds kTerminalInterval(0.1);
constexpr Seconds kLogInterval(10.0);
constexpr int kBarWidth = 24;

std::string Bar(double fraction) {
  const auto filled = static_cast<std::size_t>(fraction * kBarWidth);
  return "[" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] ";
}

}  // namespace

Progress::Progress(std::string stage, bool enabled)
    : stage_(std::move(stage)), enabled_(enabled), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { Finish(); }

void Progress::Start(std::size_t total) {
  Finish();
  const std::lock_guard lock(mutex_);
  done_ = 0;
  total_ = total;
  start_ = last_print_ = std::chrono::steady_clock::now();
}

void Progress::Advance(std::size_t count) {
  const std::lock_guard lock(mutex_);
  done_ += count;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_print_ < (terminal_ ? kTerminalInterval : kLogInterval)) return;
  last_print_ = now;
  Print(false);
}

void Progress::Finish() {
  const std::lock_guard lock(mutex_);
  if (total_ > 0 && terminal_) Print(true);
  total_ = 0;
}

void Progress::Print(bool last) {
  if (!enabled_ || total_ == 0) return;
  const double elapsed_s = Seconds(std::chrono::steady_clock::now() - start_).count();
  const double rate = static_cast<double>(done_) / std::max(elapsed_s, 1e-9);
  const double fraction = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
  const double eta_s = rate > 0 ? static_cast<double>(total_ - std::min(done_, total_)) / rate : 0;
  const std::string line = fmt::format("{} {}{}/{} {:.1f}/s ETA {:.0f}s",
                                       stage_,
                                       terminal_ ? Bar(fraction) : "",
                                       done_,
                                       total_,
                                       rate,
                                       eta_s);
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r" : "", line, terminal_ && !last ? "\x1b[K" : "\n");
}

}  // namespace nightmap
