// SPDX-License-Identifier: Apache-2.0
// One comparison of code of ours with a library's on the same input, as a row of a Markdown table.
#pragma once

#include <functional>
#include <string>

namespace nightmap {

struct Comparison {
  std::string ours;
  std::string other;
  std::string input;
  // Each does the whole work once. Their results stay with the caller, for `difference`.
  std::function<void(int num_threads)> run_ours;
  std::function<void(int num_threads)> run_other;
  // How the results differ, asked once after both ran.
  std::function<std::string()> difference;
  double num_items = 1;  // times are per item of the input
};

// Runs both by turns, once to warm up and nine times to measure, at one thread and at two. Prints
// the row: the best CPU times at one thread, which other programs disturb little, and how many
// times as long the library takes; at two threads that ratio alone, of the best wall times.
// OpenCV's own threads follow `num_threads`.
void PrintComparison(const Comparison& comparison);
void PrintHeader();

}  // namespace nightmap
