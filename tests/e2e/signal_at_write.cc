// SPDX-License-Identifier: Apache-2.0
// LD_PRELOADed by signal_at_write.py: of the first write to a file whose path contains
// SIGNAL_AT_PATH, half of the bytes are written. Then SIGNAL_AT_WRITE ends the process group, if it
// is SIGKILL, or goes to the process alone.
#include <dlfcn.h>
#include <sys/uio.h>
#include <unistd.h>

#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

bool IsAwaited(int descriptor) {
  const char* part = std::getenv("SIGNAL_AT_PATH");
  if (part == nullptr) return false;
  char path[PATH_MAX] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return readlink(link.c_str(), path, sizeof(path) - 1) > 0 && std::strstr(path, part) != nullptr;
}

void Signal() {
  const int number = std::atoi(std::getenv("SIGNAL_AT_WRITE"));
  unsetenv("SIGNAL_AT_PATH");
  kill(number == SIGKILL ? 0 : getpid(), number);
}

template <typename Function>
Function* Original(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, size_t size) {
  static auto* const original = Original<ssize_t(int, const void*, size_t)>("write");
  if (!IsAwaited(descriptor)) return original(descriptor, bytes, size);
  const ssize_t written = original(descriptor, bytes, (size + 1) / 2);
  Signal();
  return written;
}

ssize_t writev(int descriptor, const iovec* parts, int num_parts) {
  static auto* const original = Original<ssize_t(int, const iovec*, int)>("writev");
  if (!IsAwaited(descriptor)) return original(descriptor, parts, num_parts);
  while (num_parts > 1 && parts->iov_len == 0) ++parts, --num_parts;
  return write(descriptor, parts->iov_base, parts->iov_len);
}

// HDF5 writes with this one.
ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset) {
  static auto* const original = Original<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  if (!IsAwaited(descriptor)) return original(descriptor, bytes, size, offset);
  const ssize_t written = original(descriptor, bytes, (size + 1) / 2, offset);
  Signal();
  return written;
}

}  // extern "C"
