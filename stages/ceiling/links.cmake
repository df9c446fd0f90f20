# SPDX-License-Identifier: Apache-2.0
target_link_libraries(stage_${stage} PUBLIC nightmap_ceiling nightmap_camera nightmap_recording)
if(stage STREQUAL "synthesize_ceiling")
  target_link_libraries(stage_${stage} PUBLIC nightmap_world)
endif()
