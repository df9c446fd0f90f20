# SPDX-License-Identifier: Apache-2.0
# One test program per tested library: tests/<group>/*_test.cc; CTest name <group>. A program runs its tests in one process: to
# start 1,750 of them takes longer than what they test.
set(NIGHTMAP_DATA "${CMAKE_SOURCE_DIR}/../shared/data" CACHE PATH "real recordings for the tests")
find_pcl()
find_library(SUITESPARSE_CONFIG_LIBRARY suitesparseconfig REQUIRED)  # tests take CHOLMOD's memory
add_custom_target(unit_tests)  # every test program, without the stage programs
set(CMAKE_UNITY_BUILD OFF)
# Tests compile in a third of the time: -O1 is enough for what calls the libraries, and the headers
# that nearly all tests include are compiled once. (-fpch-preprocess is for ccache.)
# UndefinedBehaviorSanitizer looks for faults of the libraries.
set(test_flags -O1 -fpch-preprocess $<$<BOOL:${NIGHTMAP_SANITIZE}>:-fno-sanitize=undefined>)
add_library(test_prefix OBJECT tests/prefix.cc)
target_link_libraries(test_prefix PUBLIC nightmap_flags Eigen3::Eigen nlohmann_json::nlohmann_json GTest::gmock)
target_compile_options(test_prefix PUBLIC ${test_flags})
target_precompile_headers(test_prefix PRIVATE <gmock/gmock.h> <gtest/gtest.h> <Eigen/Geometry> <filesystem>
                          <fstream> <map> <nlohmann/json.hpp> <string> <vector>)
# A folder of tests/ or tests/stages/<wing>/ whose name is that of a library has its tests. The library of
# another stage, where tests need one, links.cmake of the folder adds.
function(nightmap_tests folder library)
  cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${CMAKE_SOURCE_DIR}/tests OUTPUT_VARIABLE group)
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*_test.cc)
  if(NOT TARGET ${library} OR NOT sources)
    return()
  endif()
  string(REPLACE "/" "_" program test_${group})
  add_executable(${program} ${sources} $<TARGET_OBJECTS:test_prefix>)
  target_link_libraries(${program} PRIVATE ${library} nightmap_world ${OCTOMAP_LIBRARIES} ${SUITESPARSE_CONFIG_LIBRARY}
                        pcl_common pcl_kdtree GTest::gmock OpenImageIO::OpenImageIO opencv_videoio)
  target_include_directories(${program} SYSTEM PRIVATE ${OCTOMAP_INCLUDE_DIRS} ${PCL_INCLUDE_DIRS})
  target_compile_options(${program} PRIVATE ${test_flags})
  target_precompile_headers(${program} REUSE_FROM test_prefix)
  # The tests of a folder compile at once. Each file has a namespace of its name, so that each may have a `kCamera`.
  set_target_properties(${program} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  include(${folder}/links.cmake OPTIONAL)
  add_dependencies(unit_tests ${program})
  add_test(NAME ${group} COMMAND /usr/bin/python3 tests/when_changed.py $<TARGET_FILE:${program}>
           WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
endfunction()
file(GLOB folders CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/*)
foreach(folder ${folders})
  cmake_path(GET folder FILENAME name)
  nightmap_tests(${folder} nightmap_${name})
endforeach()
file(GLOB folders CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/stages/*/*)
foreach(folder ${folders})
  cmake_path(GET folder FILENAME name)
  nightmap_tests(${folder} stage_${name})
endforeach()
# End-to-end tests on the stage programs, and the tests of the Python scripts. They begin before the unit tests (COST), which are
# short and fill what is left of the cores at the end. Those that measure time run alone.
set(alone costs_test preflight_test shards_test)
# Those of a list share sites: those of tests/e2e/rendered_sites.py; the demo building.
set(rendered_sites relocalization_test slam_test)
set(demo demo_test night_test slurm_test two_sensors_test)
file(GLOB scripts CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/e2e/*_test.py
     ${CMAKE_SOURCE_DIR}/tests/scripts/*_test.py)
foreach(script ${scripts})
  get_filename_component(folder ${script} DIRECTORY)
  get_filename_component(group ${folder} NAME)
  get_filename_component(name ${script} NAME_WE)
  add_test(NAME ${group}/${name} COMMAND /usr/bin/python3 -m unittest -v ${name}
           WORKING_DIRECTORY ${folder})
  set_tests_properties(${group}/${name} PROPERTIES
                       TIMEOUT 1500 COST 100 ENVIRONMENT NIGHTMAP_BUILD=${CMAKE_BINARY_DIR})
  if(name IN_LIST alone)
    set_tests_properties(${group}/${name} PROPERTIES RUN_SERIAL TRUE)
  endif()
  foreach(sites rendered_sites demo)
    if(name IN_LIST ${sites})
      set_tests_properties(${group}/${name} PROPERTIES RESOURCE_LOCK ${sites})
    endif()
  endforeach()
endforeach()
# Benchmarks: run by hand; the first lines of each say how. `make test-nightly` builds them all.
add_custom_target(benchmarks)
file(GLOB benchmarks CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/bench/bench_*.cc)
foreach(source ${benchmarks})
  get_filename_component(name ${source} NAME_WE)
  string(REPLACE bench_ stage_ stage ${name})
  add_executable(${name} EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE ${stage} nightmap_world)
  add_dependencies(benchmarks ${name})
endforeach()
