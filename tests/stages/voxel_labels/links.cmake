# SPDX-License-Identifier: Apache-2.0
target_link_libraries(test_stages_voxel_labels PRIVATE stage_octree)  # a room's voxels
