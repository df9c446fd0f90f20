// SPDX-License-Identifier: Apache-2.0
// Runs independent items on threads; each item writes its own slot.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace nightmap {

// Calls body(i) for i in [0, count) on at most `num_threads` threads. Deterministic as long as
// body(i) writes only to slot i; reduce over the slots afterwards, in order. After all started
// items have ended, it rethrows the exception of the lowest failing index.
void ParallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body);

// The same for items so short that a thread takes many of them at once.
template <typename Body>
void ParallelForShort(std::size_t count, int num_threads, const Body& body) {
  constexpr std::size_t kNumAtOnce = 2048;
  ParallelFor((count + kNumAtOnce - 1) / kNumAtOnce, num_threads, [&](std::size_t part) {
    const std::size_t end = std::min(count, (part + 1) * kNumAtOnce);
    for (std::size_t i = part * kNumAtOnce; i < end; ++i) body(i);
  });
}

}  // namespace nightmap
