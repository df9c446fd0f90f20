// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/object_evidence.h"

#include <cmath>

namespace nightmap {
namespace {

// Where the robot is, nearly all walls of objects are confirmed; elsewhere it is a toss-up.
constexpr double kConfirmedWhereTrue = 0.95;
constexpr double kConfirmedByChance = 0.5;
constexpr double kEvidenceWeight = 0.3;  // of objects, when very many walls are seen
constexpr double kEvidenceWalls = 20;    // as many weigh half of that; fewer refuse no place

double NumSeen(const ObjectView& objects) {
  return objects.num_confirmed + objects.num_contradicted;
}

// The share of confirmed walls, less the one that is as likely at the true place as by chance.
double ShareAboveChance(const ObjectView& objects) {
  static const double for_place = std::log(kConfirmedWhereTrue / kConfirmedByChance);
  static const double against = std::log((1 - kConfirmedByChance) / (1 - kConfirmedWhereTrue));
  return objects.num_confirmed / NumSeen(objects) - against / (for_place + against);
}

}  // namespace

double FitByEvidence(double walls_fit, const ObjectView& objects) {
  const double num_seen = NumSeen(objects);
  if (num_seen == 0) return walls_fit;
  const double weight = kEvidenceWeight * num_seen / (num_seen + kEvidenceWalls);
  return walls_fit + weight * ShareAboveChance(objects);
}

bool SpeakAgainst(const ObjectView& objects) {
  return NumSeen(objects) >= kEvidenceWalls && ShareAboveChance(objects) < 0;
}

}  // namespace nightmap
