# SPDX-License-Identifier: Apache-2.0
# ply_io_test opens a cloud in PCL.
find_library(PCL_IO_LIBRARY pcl_io REQUIRED)
find_library(PCL_IO_PLY_LIBRARY pcl_io_ply REQUIRED)
target_link_libraries(${program} PRIVATE ${PCL_IO_LIBRARY} ${PCL_IO_PLY_LIBRARY})
