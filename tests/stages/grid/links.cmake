# SPDX-License-Identifier: Apache-2.0
target_link_libraries(test_stages_grid PRIVATE stage_plan)  # paths on its grids
