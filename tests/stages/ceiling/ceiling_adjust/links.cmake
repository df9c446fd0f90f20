# SPDX-License-Identifier: Apache-2.0
# The filter makes the map that is adjusted.
target_link_libraries(${program} PRIVATE stage_ceiling_ekf)
