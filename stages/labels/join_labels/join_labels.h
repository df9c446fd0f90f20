// SPDX-License-Identifier: Apache-2.0
// join_labels: joins the labelled voxels of all tiles, and colors octree and cloud by them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/octree_leaves.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/dense/voxel_labels_io.h"
#include "stages/labels/join_labels/palette.h"

namespace nightmap {

struct JoinLabelsOptions {
  OPTION(std::vector<std::string>, palette, std::vector<std::string>(),
         "color per class, \"#rrggbb\", in the order of the model; none: those of PASCAL VOC");
  OPTION(double, max_failed_ratio, 0.05, {0.0, 1.0},
         "share of unreadable keyframes above which the stage fails");
  REGISTER_OPTIONS();
};

// All voxels in Morton order, whatever the order of the parts. Throws DataError when parts overlap,
// or differ in resolution or classes.
VoxelLabels JoinVoxelLabels(const std::vector<VoxelLabels>& parts);

// Writes the tree as `.ot` with the classes' colors (ClassColors): log-odds and leaves are those
// of `leaves`, except that eight occupied leaves of several classes stay eight. Throws DataError
// naming the file.
void WriteLabelledOctree(const std::filesystem::path& path,
                         const LeafSource& leaves,
                         const VoxelLabels& voxels,
                         const std::vector<Rgb>& palette);

// Finds the class at a point of the map.
class LabelAt {
 public:
  // `voxels` must outlive it.
  explicit LabelAt(const VoxelLabels& voxels);
  // 0 where no voxel is labelled.
  std::uint8_t operator()(const Eigen::Vector3d& point_in_map) const;

 private:
  const VoxelLabels& voxels_;
  std::vector<std::uint64_t> codes_;
};

// Voxels per class, by the class that most speaks for.
std::vector<std::size_t> CountClasses(const VoxelLabels& voxels);

// Names, colors and numbers of voxels of the classes, as JSON.
std::string LegendJson(const VoxelLabels& voxels, const std::vector<Rgb>& palette);

}  // namespace nightmap
