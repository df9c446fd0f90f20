# SPDX-License-Identifier: Apache-2.0
nightmap_library(dense LINK nightmap_io opencv_core)
