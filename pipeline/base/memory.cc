// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/memory.h"

#include <malloc.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <system_error>

namespace nightmap {
namespace {

// More than all threads free in the moment after one was refused.
constexpr std::size_t kSpare_bytes = std::size_t{256} << 20;

bool IsSpareMemory() {
  const std::unique_ptr<void, void (*)(void*)> spare(std::malloc(kSpare_bytes), std::free);
  return spare != nullptr;
}

}  // namespace

void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

OutOfMemory::OutOfMemory(const std::string& at_file) : message_("out of memory at " + at_file) {}

bool IsOutOfMemory(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error)) return true;
  if (const auto* refused = dynamic_cast<const std::system_error*>(&error)) {
    return refused->code() == std::errc::resource_unavailable_try_again ||
           refused->code() == std::errc::not_enough_memory;
  }
  constexpr std::array<std::string_view, 4> kTexts = {
      "Insufficient memory", "bad_alloc", "failed to map segment", "annot allocate memory"};
  const std::string_view text = error.what();
  return std::ranges::any_of(
      kTexts, [&](std::string_view part) { return text.find(part) != std::string_view::npos; });
}

MemoryWatch::MemoryWatch() { errno = 0; }

void MemoryWatch::Check(const std::string& at_file) const {
  // The allocator leaves ENOMEM behind also where it found memory elsewhere.
  if (errno == ENOMEM && !IsSpareMemory()) throw OutOfMemory(at_file);
}

}  // namespace nightmap
