// SPDX-License-Identifier: Apache-2.0
// Tells memory that ran out from data that is bad: the first ends the stage, because the same work
// succeeds with more memory; the second costs one item.
#pragma once

#include <exception>
#include <new>
#include <string>

namespace nightmap {

// No Error, so that nothing that skips a bad item catches it.
class OutOfMemory : public std::bad_alloc {
 public:
  explicit OutOfMemory(const std::string& at_file);
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  std::string message_;
};

// Whether an exception says that the system gave no memory or no thread (whose stack is memory).
// Libraries say so in types of their own.
bool IsOutOfMemory(const std::exception& error);

// Gives memory that was freed in small pieces back to the system, before large arrays are asked
// for: malloc keeps it for further small pieces.
void ReturnFreeMemory();

// Watches the calls of a library that reports lack of memory as a damaged file.
class MemoryWatch {
 public:
  MemoryWatch();
  // Throws OutOfMemory when this thread was refused memory since the watch began and memory still
  // is short.
  void Check(const std::string& at_file) const;
};

}  // namespace nightmap
