# SPDX-License-Identifier: Apache-2.0
nightmap_library(labels LINK nightmap_io opencv_core opencv_imgproc opencv_dnn SYSTEM ${OpenCV_INCLUDE_DIRS})
