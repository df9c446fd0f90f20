// SPDX-License-Identifier: Apache-2.0
// import_grid: reads the YAML and PGM of a ROS map; writes them as the grid stage writes its own.
#include "stages/import_grid/import_grid.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"import_grid",
                       "imports a ROS map of another system as the grid of the site",
                       {{"map", "YAML of map_server; its PGM is found next to it"},
                        {"trajectory", "trajectory.tum of the map_frame stage"}},
                       {{"floors", "floors.json: one floor at z = 0"},
                        {"pgm", "grid: 254 free, 0 occupied, 205 unknown"},
                        {"yaml", "map_server's description of that image"},
                        {"png", "the grid as a picture"}}};
  return StageMain(argc, argv, spec, ImportGridOptions{}, ImportGrid);
}
