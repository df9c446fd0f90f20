# SPDX-License-Identifier: Apache-2.0
target_link_libraries(stage_${stage} PUBLIC nightmap_labels nightmap_camera nightmap_dense)
if(stage STREQUAL "things")
  link_pcl(things ${folder}/clusters.cc)
endif()
