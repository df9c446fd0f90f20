#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# PCL 1.13.0 (Debian 12: libpcl-dev 1.13.0+dfsg-3) is found once in a CMake project. Its FindFLANN.cmake returns at once when its target
# exists, and leaves FLANN_FOUND unset; so a second find_package in another scope, such as a function that is called per library, finds
# no FLANN, and PCLConfig.cmake, which asks it for kdtree and search, ends with "kdtree is required but flann was not found".
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq libpcl-dev=1.13.0+dfsg-3 libflann-dev=1.9.2+dfsg-1+deb12u1 libflann1.9=1.9.2+dfsg-1+deb12u1 >/dev/null 2>&1
for package in *.deb; do dpkg -x "$package" packages; done
cat >CMakeLists.txt <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(twice CXX)
function(find_it)
  find_package(FLANN QUIET)
  message(STATUS "found: '${FLANN_FOUND}'")
endfunction()
find_it()
find_it()
CMAKE
folder_of() { dirname "$folder/$(find packages -name "$1")"; }
cmake -S . -B build -DCMAKE_MODULE_PATH="$(folder_of FindFLANN.cmake)" -Dflann_DIR="$(folder_of flann-config.cmake)" >seen.txt
grep found: seen.txt | tee seen
printf -- "-- found: '%s'\n" ON '' | cmp seen -
