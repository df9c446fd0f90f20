# SPDX-License-Identifier: Apache-2.0
target_link_libraries(test_stages_octree PRIVATE stage_tiles)  # octrees of its tiles
