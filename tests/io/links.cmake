# SPDX-License-Identifier: Apache-2.0
# corrupt_artifacts_test damages the formats of every library.
target_link_libraries(${program} PRIVATE nightmap_camera nightmap_dense nightmap_laser nightmap_recording)
