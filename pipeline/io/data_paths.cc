// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/data_paths.h"

namespace nightmap {

std::string WithoutDataRoot(std::string message,
                            const std::filesystem::path& data_root,
                            const std::string& file) {
  const std::string path = (data_root / file).string();
  for (std::size_t at = message.find(path); at != std::string::npos;
       at = message.find(path, at + file.size())) {
    message.replace(at, path.size(), file);
  }
  return message;
}

}  // namespace nightmap
