# SPDX-License-Identifier: Apache-2.0
target_link_libraries(${program} PRIVATE stage_join_clouds)  # clouds of its tiles
