# SPDX-License-Identifier: Apache-2.0
target_link_libraries(${program} PRIVATE stage_tiles)  # octrees of its tiles
