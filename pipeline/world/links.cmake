# SPDX-License-Identifier: Apache-2.0
if(mains MATCHES "/synthesize")
  find_package(embree 3 REQUIRED)
  nightmap_library(world LINK nightmap_io embree)
endif()
