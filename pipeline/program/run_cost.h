// SPDX-License-Identifier: Apache-2.0
// Measures the time and memory that a run of a program takes, for its receipt.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

namespace nightmap {

// The time that all threads of the process have computed so far.
double CpuTime_s();

class RunCost {
 public:
  RunCost();  // the run starts here

  double WallTime_s() const;

  // start_time (UTC) and wall_time_s since the constructor; cpu_time_s of all threads and
  // peak_memory_bytes (resident) of the process so far.
  nlohmann::json ForReceipt() const;

 private:
  std::chrono::steady_clock::time_point start_;
  std::string start_utc_;
};

}  // namespace nightmap
