# SPDX-License-Identifier: Apache-2.0
# One test program per tested library: tests/<group>/*_test.cc; CTest name <group>/<suite.test>.
include(GoogleTest)
set(NIGHTMAP_DATA "${CMAKE_SOURCE_DIR}/../shared/data" CACHE PATH "real recordings for the tests")
add_custom_target(unit_tests)  # every test program, without the stage programs
function(nightmap_tests group)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/${group}/*_test.cc)
  if(NOT sources)
    return()
  endif()
  string(REPLACE "/" "_" program test_${group})
  add_executable(${program} ${sources})
  target_link_libraries(${program} PRIVATE ${ARG_LINK} GTest::gtest_main GTest::gmock)
  add_dependencies(unit_tests ${program})
  gtest_discover_tests(${program} TEST_PREFIX ${group}/ DISCOVERY_TIMEOUT 120
                       WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
endfunction()
nightmap_tests(base LINK nightmap_base)
find_library(SUITESPARSE_CONFIG_LIBRARY suitesparseconfig REQUIRED)  # a test takes CHOLMOD's memory
nightmap_tests(geometry LINK nightmap_geometry ${SUITESPARSE_CONFIG_LIBRARY})
nightmap_tests(io LINK nightmap_io ${OCTOMAP_LIBRARIES})
nightmap_tests(recording LINK nightmap_recording)
nightmap_tests(vision LINK nightmap_vision)
nightmap_tests(synthetic LINK nightmap_synthetic)
file(GLOB stage_folders RELATIVE ${CMAKE_SOURCE_DIR}/stages ${CMAKE_SOURCE_DIR}/stages/*)
foreach(stage ${stage_folders})
  if(TARGET stage_${stage})
    nightmap_tests(stages/${stage} LINK stage_${stage} nightmap_synthetic)
  endif()
endforeach()
if(TARGET test_stages_pose_graph)
  target_link_libraries(test_stages_pose_graph PRIVATE ${SUITESPARSE_CONFIG_LIBRARY})
endif()
if(TARGET test_stages_point_cloud)
  target_link_libraries(test_stages_point_cloud PRIVATE pcl_common pcl_kdtree)
  target_include_directories(test_stages_point_cloud SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
endif()
if(TARGET test_stages_point_cloud AND TARGET stage_join_clouds)
  target_link_libraries(test_stages_point_cloud PRIVATE stage_join_clouds)  # clouds of its tiles
endif()
if(TARGET test_stages_octree AND TARGET stage_tiles)
  target_link_libraries(test_stages_octree PRIVATE stage_tiles)  # octrees of its tiles
endif()
if(TARGET test_stages_grid AND TARGET stage_plan)
  target_link_libraries(test_stages_grid PRIVATE stage_plan)  # paths on its grids
endif()
# End-to-end tests on the stage programs, and the tests of the Python scripts.
file(GLOB scripts CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/e2e/*_test.py
     ${CMAKE_SOURCE_DIR}/tests/scripts/*_test.py)
foreach(script ${scripts})
  get_filename_component(folder ${script} DIRECTORY)
  get_filename_component(group ${folder} NAME)
  get_filename_component(name ${script} NAME_WE)
  add_test(NAME ${group}/${name} COMMAND /usr/bin/python3 -m unittest -v ${name}
           WORKING_DIRECTORY ${folder})
  set_tests_properties(${group}/${name} PROPERTIES
                       RUN_SERIAL TRUE TIMEOUT 1500 ENVIRONMENT NIGHTMAP_BUILD=${CMAKE_BINARY_DIR})
endforeach()
# Benchmarks: run by hand; the first lines of each say how.
file(GLOB benchmarks CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/bench/bench_*.cc)
foreach(source ${benchmarks})
  get_filename_component(name ${source} NAME_WE)
  string(REPLACE bench_ stage_ stage ${name})
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE ${stage})
endforeach()
