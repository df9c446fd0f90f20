# SPDX-License-Identifier: Apache-2.0
target_link_libraries(stage_${stage} PUBLIC nightmap_laser nightmap_graph nightmap_recording)
if(stage STREQUAL "scan_localize")
  link_pcl(scan_localize ${folder}/object_icp.cc)
endif()
