// SPDX-License-Identifier: Apache-2.0
// Runs independent items on threads; each item writes its own slot.
#pragma once

#include <cstddef>
#include <functional>

namespace nightmap {

// Calls body(i) for i in [0, count) on at most `num_threads` threads. Deterministic as long as
// body(i) writes only to slot i; reduce over the slots afterwards, in order. After all started
// items have ended, it rethrows the exception of the lowest failing index.
void ParallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body);

}  // namespace nightmap
