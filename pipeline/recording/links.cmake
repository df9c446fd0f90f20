# SPDX-License-Identifier: Apache-2.0
nightmap_library(recording LINK nightmap_io)
