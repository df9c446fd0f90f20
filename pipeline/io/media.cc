// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/media.h"

#include <dlfcn.h>
#include <media_sources.h>

#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/memory.h"

namespace nightmap {
namespace {

// The programs lie beside the module; those of tests one folder above.
std::filesystem::path ModulePath() {
  const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  std::error_code ignored;
  const auto beside = folder / "nightmap_media.so";
  return std::filesystem::exists(beside, ignored) ? beside : folder / "bin" / beside.filename();
}

Media* Load() {
  const std::filesystem::path path = ModulePath();
  void* module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!module) {
    const UsageError error("{}: {}: build the programs again", path.string(), dlerror());
    if (IsOutOfMemory(error)) throw OutOfMemory(path.string());
    throw error;
  }
  auto* sources = reinterpret_cast<const char* (*)()>(dlsym(module, "NightmapMediaSources"));
  auto* media = reinterpret_cast<Media* (*)()>(dlsym(module, "NightmapMedia"));
  if (!sources || !media || sources() != std::string_view(NIGHTMAP_MEDIA_SOURCES)) {
    throw UsageError("{}: is of another build than this program: build the programs again",
                     path.string());
  }
  return media();
}

}  // namespace

Media& LoadedMedia() {
  static Media* media = Load();
  return *media;
}

}  // namespace nightmap
