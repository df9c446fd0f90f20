# SPDX-License-Identifier: Apache-2.0
target_link_libraries(${program} PRIVATE nightmap_recording)  # reads what it records
