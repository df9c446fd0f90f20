// SPDX-License-Identifier: Apache-2.0
// Plan of the building whose ceilings a robot sees: free space as axis-aligned rectangles, each
// with a ceiling of its own height.
//
// Building frame: z up, floor z = 0, metres. Rectangles touch and do not overlap. Where two touch,
// one sees from one into the other below the lower ceiling; all other sides are walls.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/world/scene.h"

namespace nightmap {

// Pitch of ceiling tiles; lamps come in whole tiles.
inline constexpr double kCeilingTile_m = 0.6;

enum class CeilingFinish {
  kMineral,   // tiles in a T-bar grid, each with specks of its own
  kRepeated,  // tiles in a T-bar grid, all with the same specks
  kPlaster,   // blemishes
  kBlank,     // nothing to see, neither on the ceiling nor on the walls
  kPaint,     // beams and lintels: weak mottle
};

struct CeilingRect {
  Rect2 area;
  double height_m = 2.6;
  CeilingFinish finish = CeilingFinish::kPlaster;
  int look = 0;  // equally large rectangles of one look and finish look the same
};

enum class FittingKind { kLamp, kVent, kSprinkler, kSmokeDetector, kPipe };

// Something on the ceiling, flush with it.
struct CeilingFitting {
  FittingKind kind = FittingKind::kLamp;
  Rect2 area;    // building frame; round things: their bounding square
  int rect = 0;  // index of the rectangle whose ceiling it is on
};

// Points that the robot drives through in one go. Between two legs it turns on the spot.
using CeilingLeg = std::vector<Eigen::Vector2d>;

struct CeilingPlan {
  std::vector<CeilingRect> rects;
  std::vector<CeilingFitting> fittings;
  Rect2 blank;                   // stretch without any texture; area 0: none
  std::vector<CeilingLeg> legs;  // the robot's route

  // Index of a rectangle that holds the point, -1 outside.
  int RectAt(double x, double y) const;
  // Whether no wall is nearer than `clearance_m` (tested in 32 directions).
  bool IsFree(const Eigen::Vector2d& point, double clearance_m) const;
};

// A loop of corridors, 2 m wide, with a centre line of 40 m x 20 m: all finishes, beams, a fire
// door, a stretch of 3.1 m height, a blank stretch of `blank_length_m` (0 to 12). The route is one
// loop and overlap_m, then 5 m back. `seed` decides specks and fittings.
CeilingPlan PlanCeilingCorridor(double blank_length_m, double overlap_m, int seed);

// Six rooms of 5 m x 4 m, three on each side of a corridor. The outer rooms of the first side look
// the same. The route goes into each room and out again, then back to its start. `seed` decides
// specks and fittings.
CeilingPlan PlanCeilingOffice(int seed);

// Adds what hangs on the ceiling of rectangle `rect`, as its finish has it.
void AddFittings(int rect, int seed, CeilingPlan& plan);

}  // namespace nightmap
