// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/voxel_labels_io.h"

#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::voxel_labels_io_test {

VoxelLabels SomeVoxels() {
  VoxelLabels voxels;
  voxels.resolution_m = 0.05;
  voxels.classes = {"none", "chair", "dining table"};
  voxels.keys = {{-3, 2, -1}, {0, 0, 0}, {1, 0, 0}};
  voxels.num_views = {1, 2, 7};
  voxels.vote_offsets = {0, 1, 3, 4};
  voxels.vote_labels = {2, 0, 1, 1};
  voxels.vote_weights = {0.25F, 0.5F, 1.5F, 7};
  return voxels;
}

TEST(VoxelLabelsIo, ReadsBackWhatItWrote) {
  const TemporaryFolder folder;
  const VoxelLabels voxels = SomeVoxels();
  WriteVoxelLabels(folder / "a.h5", voxels, "x = 1\n");
  WriteVoxelLabels(folder / "b.h5", voxels, "x = 1\n");
  EXPECT_EQ(HashFile(folder / "a.h5"), HashFile(folder / "b.h5"));
  const VoxelLabels read = ReadVoxelLabels(folder / "a.h5");
  EXPECT_EQ(read.resolution_m, voxels.resolution_m);
  EXPECT_EQ(read.classes, voxels.classes);
  EXPECT_EQ(read.keys, voxels.keys);
  EXPECT_EQ(read.num_views, voxels.num_views);
  EXPECT_EQ(read.vote_offsets, voxels.vote_offsets);
  EXPECT_EQ(read.vote_labels, voxels.vote_labels);
  EXPECT_EQ(read.vote_weights, voxels.vote_weights);
}

TEST(VoxelLabelsIo, HoldsNoVoxelsAtAll) {
  const TemporaryFolder folder;
  VoxelLabels voxels;
  voxels.resolution_m = 0.1;
  voxels.classes = {"a", "b"};
  WriteVoxelLabels(folder / "a.h5", voxels, "");
  EXPECT_EQ(ReadVoxelLabels(folder / "a.h5").Size(), 0U);
}

TEST(VoxelLabelsIo, TheClassIsWhatMostVotesSpeakFor) {
  const VoxelLabels voxels = SomeVoxels();
  EXPECT_EQ(LabelOf(voxels, 0).label, 2);
  EXPECT_EQ(LabelOf(voxels, 0).share, 1);
  EXPECT_EQ(LabelOf(voxels, 1).label, 1);
  EXPECT_EQ(LabelOf(voxels, 1).share, 0.75);
  VoxelLabels equal = voxels;
  equal.vote_weights[1] = equal.vote_weights[2];
  EXPECT_EQ(LabelOf(equal, 1).label, 0);  // the smaller index
}

TEST(VoxelLabelsIo, RefusesWhatDoesNotFit) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::function<void(VoxelLabels&)>& damage, const char* field) {
    VoxelLabels voxels = SomeVoxels();
    damage(voxels);
    WriteVoxelLabels(folder / "v.h5", voxels, "");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadVoxelLabels(folder / "v.h5"), field);
  };
  expect([](auto& v) { v.resolution_m = 0; }, "resolution_m");
  expect([](auto& v) { v.classes[1] = ""; }, "classes");
  expect([](auto& v) { v.classes.pop_back(); }, "vote_label");
  expect([](auto& v) { std::swap(v.keys[0], v.keys[1]); }, "key");
  expect([](auto& v) { v.keys[1] = v.keys[0]; }, "key");
  expect([](auto& v) { v.keys[0].x() = 1 << 15; }, "key");
  expect([](auto& v) { v.num_views[0] = -1; }, "num_views");
  expect([](auto& v) { v.num_views.pop_back(); }, "num_views");
  expect([](auto& v) { v.vote_offsets[1] = 0; }, "vote_offset");
  expect([](auto& v) { v.vote_offsets.pop_back(); }, "vote_offset");
  expect([](auto& v) { v.vote_labels[2] = 0; }, "vote_label");
  expect([](auto& v) { v.vote_weights[0] = 0; }, "vote_weight");
  expect([](auto& v) { v.vote_weights.push_back(1); }, "vote_weight");
  expect([](auto& v) { v.vote_weights[0] = std::numeric_limits<float>::quiet_NaN(); },
         "vote_weight");
}

}  // namespace nightmap::voxel_labels_io_test
