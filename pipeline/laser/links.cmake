# SPDX-License-Identifier: Apache-2.0
nightmap_library(laser LINK nightmap_plan Ceres::ceres)
