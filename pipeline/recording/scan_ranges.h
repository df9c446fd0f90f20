// SPDX-License-Identifier: Apache-2.0
// Facts about a scanner by the ranges of all its scans: their unit, and the range that it
// writes where nothing was hit.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "pipeline/recording/signals_io.h"

namespace nightmap {

// Throws DataError, which names the file and says what to write, when the ranges cannot be metres:
// when half of those that differ from the largest, which may stand for no hit, are 100 or more. A
// laser scanner of a robot does not see so far.
void DemandMetres(const Signal& scans, const std::filesystem::path& path);

// The range that a scanner writes where it hit nothing, below the scans' limit; none when it writes
// no such range or the scans do not tell. It is the range of many beams in all directions exactly,
// nearly nothing is farther, and all other ranges about as large are far rarer. Real hits do not
// look so: noise, or resolution, spreads it over neighbouring values. Pure.
std::optional<float> RangeOfNoHit_m(const std::vector<SignalSample>& scans);
// Likewise, and makes it the limit of the scans.
std::optional<float> LimitToHits(std::vector<SignalSample>* scans);

}  // namespace nightmap
