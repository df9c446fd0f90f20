// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace nightmap {
namespace {

// From this number on items are small, so threads take several at a time.
constexpr std::size_t kManyItems = 4096;
constexpr std::size_t kMaxChunk = 64;

// The failure with the lowest index seen so far.
class FirstFailure {
 public:
  void Record(std::size_t index, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (!error_ || index < index_) {
      index_ = index;
      error_ = std::move(error);
    }
  }
  void Rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::mutex mutex_;
  std::size_t index_ = 0;
  std::exception_ptr error_;
};

}  // namespace

void ParallelFor(std::size_t count, int num_threads, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  FirstFailure failure;
  const std::size_t chunk = std::clamp(count / kManyItems, std::size_t{1}, kMaxChunk);
  const auto work = [&] {
    // Chunks are handed out in order and run up to their own first failure. So every index below a
    // failing one is tried, and the lowest failure is the same at any number of threads.
    while (!stop) {
      const std::size_t begin = next.fetch_add(chunk);
      if (begin >= count) return;
      std::size_t index = begin;
      try {
        for (; index < std::min(begin + chunk, count); ++index) body(index);
      } catch (...) {
        failure.Record(index, std::current_exception());
        stop = true;
      }
    }
  };
  const std::size_t num_helpers =
      std::min(count, static_cast<std::size_t>(std::max(1, num_threads))) - (count > 0 ? 1 : 0);
  std::vector<std::thread> helpers;
  helpers.reserve(num_helpers);
  try {
    for (std::size_t i = 0; i < num_helpers; ++i) helpers.emplace_back(work);
  } catch (const std::exception&) {
    // The system grants no more threads or no memory for them; the existing ones do the work.
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  failure.Rethrow();
}

}  // namespace nightmap
