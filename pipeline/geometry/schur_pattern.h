// SPDX-License-Identifier: Apache-2.0
// The pattern of bundle adjustment's reduced system: which poses share points.
#pragma once

#include "pipeline/geometry/block_pattern.h"
#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/geometry/index_groups.h"

namespace nightmap {

// Takes which pose sees which point, as observations by pose and by point. Throws DataError when
// the system is too large. The same at any number of threads.
BlockPattern MakeSchurPattern(const BundleProblem& problem,
                              const IndexGroups& of_pose,
                              const IndexGroups& of_point,
                              int num_calibrations,
                              int num_threads);

}  // namespace nightmap
