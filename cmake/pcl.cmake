# SPDX-License-Identifier: Apache-2.0
# PCL compiles slowly and needs many libraries: only the stages that use it know it. Its targets would bring the headers and flags of
# VTK and Qt along, its files do not. PCL 1.13 is found once in a configuration: a second find_package in another scope misses FLANN.
function(find_pcl)
  if(NOT TARGET pcl_common)
    find_package(PCL REQUIRED COMPONENTS common kdtree search filters registration)
    set(PCL_INCLUDE_DIRS ${PCL_INCLUDE_DIRS} CACHE INTERNAL "headers of PCL and of what it stands on")
  endif()
endfunction()

# The source that includes PCL is compiled apart from the batch, which would be as slow at every edit. GCC 12 reports array-bounds
# falsely in Eigen's vectors of three floats.
function(link_pcl stage source)
  find_pcl()
  foreach(library registration filters search kdtree common)
    target_link_libraries(stage_${stage} PUBLIC $<TARGET_FILE:pcl_${library}>)
  endforeach()
  target_include_directories(stage_${stage} SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
  set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON COMPILE_OPTIONS -Wno-array-bounds)
endfunction()
