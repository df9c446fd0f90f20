// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/run_cost.h"

#include <sys/resource.h>

#include <cstdint>
#include <ctime>

namespace nightmap {
namespace {

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

rusage Usage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

}  // namespace

double CpuTime_s() {
  const rusage usage = Usage();
  return Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
}

RunCost::RunCost() : start_(std::chrono::steady_clock::now()), start_utc_(UtcNow()) {}

double RunCost::WallTime_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

nlohmann::json RunCost::ForReceipt() const {
  return {{"start_time", start_utc_},
          {"wall_time_s", WallTime_s()},
          {"cpu_time_s", CpuTime_s()},
          {"peak_memory_bytes", static_cast<std::int64_t>(Usage().ru_maxrss) * 1024}};
}

}  // namespace nightmap
