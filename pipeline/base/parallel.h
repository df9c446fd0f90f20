// SPDX-License-Identifier: Apache-2.0
// The one way to use threads: independent items, each writing its own slot.
#pragma once

#include <cstddef>
#include <functional>

namespace nightmap {

// Calls body(i) for i in [0, count) on at most `num_threads` threads. Deterministic as long as
// body(i) writes only to slot i: reduce over the slots afterwards, in order. The exception of the
// lowest failing index is rethrown after all started items have ended.
void ParallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body);

}  // namespace nightmap
