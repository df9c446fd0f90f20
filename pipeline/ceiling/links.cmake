# SPDX-License-Identifier: Apache-2.0
nightmap_library(ceiling LINK nightmap_io)
