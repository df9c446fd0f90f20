// SPDX-License-Identifier: Apache-2.0
// Evidence of confirmed and contradicted walls of objects for a place: the ratio of likelihoods
// where the robot is and elsewhere. Used by the method `published`.
#pragma once

#include "stages/laser/scan_localize/object_views.h"

namespace nightmap {

// The fit of the walls, raised where the share of confirmed walls is likelier at the true place,
// lowered where it is likelier by chance. A place that sees no object keeps its fit, so that places
// with and without objects in sight compare. Pure.
double FitByEvidence(double walls_fit, const ObjectView& objects);

// Whether enough walls of objects are seen, and in a share that is likelier by chance.
bool SpeakAgainst(const ObjectView& objects);

}  // namespace nightmap
