# SPDX-License-Identifier: Apache-2.0
# Closed graphs are made from the circle of pose_graph's tests.
target_link_libraries(${program} PRIVATE stage_pose_graph)
