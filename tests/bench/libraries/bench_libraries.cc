// SPDX-License-Identifier: Apache-2.0
// Compares code of ours with the library that does the same, on a recording and its map, and prints
// the table of docs/ours_instead_of.md. tests/bench/bench_libraries.py runs it.
#include <iostream>
#include <string>

#include "pipeline/base/error.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: bench_libraries DATA MAPS/SITE ...\n";
    return 2;
  }
  try {
    nightmap::PrintHeader();
    for (int i = 2; i < argc; ++i) {
      const nightmap::MappedSite site = nightmap::ReadMappedSite(argv[i], argv[1]);
      nightmap::CompareCameras(site);
      nightmap::CompareMatchers(site);
      nightmap::CompareKMeans(site);
      nightmap::ComparePoses(site);
      nightmap::CompareSmallSolver(site);
      nightmap::CompareBundleAdjustment(site);
      nightmap::CompareClouds(nightmap::CloudOfSite(site));
      nightmap::CompareOctrees(site);
    }
    nightmap::CompareClouds(nightmap::CloudOfBoxRoom());
    nightmap::CompareDistanceTransforms();
  } catch (const nightmap::DataError& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
