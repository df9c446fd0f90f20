// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipeline/dense/octree_leaves.h"

namespace nightmap {

// The bytes of an `.ot` without the comment that has their hash, as another program writes them.
inline std::string WithoutHash(std::string bytes) {
  const std::size_t begin = bytes.find(kOctreeHashLine);
  return bytes.erase(begin, bytes.find('\n', begin) + 1 - begin);
}

}  // namespace nightmap
