# SPDX-License-Identifier: Apache-2.0
nightmap_library(camera LINK nightmap_io opencv_core opencv_imgproc opencv_features2d opencv_video SYSTEM ${OpenCV_INCLUDE_DIRS})
