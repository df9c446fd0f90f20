# SPDX-License-Identifier: Apache-2.0
nightmap_library(graph LINK nightmap_io)
