// SPDX-License-Identifier: Apache-2.0
// Time of ceiling_ekf per picture, with 500 landmarks in the map and with 5,000. Simulated tracks,
// one thread:
//   ninja -C build bench_ceiling_ekf && build/bench_ceiling_ekf
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "tests/stages/ceiling/ceiling_ekf/simulated_drive.h"

namespace nightmap {
namespace {

struct Cost {
  double seconds = 0;
  double num_landmarks = 0;
};

double CpuTime_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

// The cost is that of the best of three runs over the first pictures of a drive.
Cost CostOf(const SimulatedDrive& drive, std::size_t num_frames) {
  CeilingEkfInput input = drive.input;
  input.tracks.frames.resize(num_frames);
  Cost best{1e9, 0};
  for (int run = 0; run < 3; ++run) {
    Progress progress("bench", false);
    const double start_s = CpuTime_s();
    const CeilingEkfResult result = RunCeilingEkf({}, input, progress);
    best.seconds = std::min(best.seconds, CpuTime_s() - start_s);
    best.num_landmarks = static_cast<double>(result.map.landmarks.size());
  }
  return best;
}

void Run() {
  DriveOptions options;
  options.side_m = 80;  // nothing is seen twice
  options.path_m = 300;
  const SimulatedDrive drive = Simulate(options);
  fmt::print("| pictures | landmarks at the end | ms per picture |\n|---:|---:|---:|\n");
  std::size_t before = 0;
  double before_s = 0;
  for (const std::size_t end : {200U, 600U, 3600U, 4600U}) {
    const Cost cost = CostOf(drive, end);
    fmt::print("| {} to {} | {:.0f} | {:.2f} |\n",
               before,
               end,
               cost.num_landmarks,
               1e3 * (cost.seconds - before_s) / static_cast<double>(end - before));
    before = end;
    before_s = cost.seconds;
  }
}

}  // namespace
}  // namespace nightmap

int main() {
  nightmap::Run();
  return 0;
}
