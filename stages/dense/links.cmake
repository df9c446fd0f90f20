# SPDX-License-Identifier: Apache-2.0
target_link_libraries(stage_${stage} PUBLIC nightmap_dense nightmap_plan nightmap_recording ${OCTOMAP_LIBRARIES})
target_include_directories(stage_${stage} SYSTEM PUBLIC ${OCTOMAP_INCLUDE_DIRS})
if(stage STREQUAL "mesh")
  link_pcl(mesh ${folder}/cube_cases.cc)
endif()
