// SPDX-License-Identifier: Apache-2.0
// The comparisons, by subject; each prints its rows.
#pragma once

#include "tests/bench/libraries/cloud_input.h"
#include "tests/bench/libraries/mapped_site.h"

namespace nightmap {

void CompareCameras(const MappedSite& site);
void CompareMatchers(const MappedSite& site);
void CompareKMeans(const MappedSite& site);
void ComparePoses(const MappedSite& site);
void CompareSmallSolver(const MappedSite& site);
void CompareBundleAdjustment(const MappedSite& site);
void CompareClouds(const CloudInput& input);
void CompareOctrees(const MappedSite& site);
void CompareDistanceTransforms();  // on a made-up office floor

}  // namespace nightmap
