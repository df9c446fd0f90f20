# SPDX-License-Identifier: Apache-2.0
# hdf5_formats_test and corrupt_artifacts_test damage the formats of every library.
target_link_libraries(${program} PRIVATE nightmap_camera nightmap_dense nightmap_laser nightmap_recording)
