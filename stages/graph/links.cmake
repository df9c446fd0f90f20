# SPDX-License-Identifier: Apache-2.0
target_link_libraries(stage_${stage} PUBLIC nightmap_graph nightmap_recording)
