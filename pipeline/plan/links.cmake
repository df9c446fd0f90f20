# SPDX-License-Identifier: Apache-2.0
nightmap_library(plan LINK nightmap_io opencv_core opencv_imgproc)
