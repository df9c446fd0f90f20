# SPDX-License-Identifier: Apache-2.0
# What is adjusted is made by the filter.
target_link_libraries(${program} PRIVATE stage_ceiling_ekf)
