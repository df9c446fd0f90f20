// SPDX-License-Identifier: Apache-2.0
// Numbers as they are in memory, to and from the bytes of a little-endian file.
#pragma once

#include <bit>
#include <cstring>

namespace nightmap {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

template <typename T>
void Put(const T& value, char*& to) {
  std::memcpy(to, &value, sizeof(value));
  to += sizeof(value);
}

template <typename T>
void Take(const char*& from, T& value) {
  std::memcpy(&value, from, sizeof(value));
  from += sizeof(value);
}

}  // namespace nightmap
