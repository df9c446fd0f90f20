# SPDX-License-Identifier: Apache-2.0
# corrupt_artifacts_test damages the formats of every library.
target_link_libraries(${program} PRIVATE nightmap_features nightmap_dense nightmap_planar nightmap_recording)
