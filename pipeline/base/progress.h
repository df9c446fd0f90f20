// SPDX-License-Identifier: Apache-2.0
// Shows the progress of a long stage on stderr: a bar on a terminal, otherwise an occasional line.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace nightmap {

// Thread safe. Prints `features 120/600 31.0/s ETA 15s`; never touches stdout.
class Progress {
 public:
  explicit Progress(std::string stage, bool enabled = true);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Starts counting from zero to `total` items of work.
  void Start(std::size_t total);
  void Advance(std::size_t count = 1);
  void Finish();

 private:
  void Print(bool last);

  std::string stage_;
  bool enabled_;
  bool terminal_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::size_t total_ = 0;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_print_;
};

}  // namespace nightmap
