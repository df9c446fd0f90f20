# SPDX-License-Identifier: Apache-2.0
target_link_libraries(${program} PRIVATE stage_octree)  # a room's voxels
