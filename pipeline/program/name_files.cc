// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/name_files.h"

namespace nightmap {
namespace {

// "a.h5", or "a.h5 (or another of 3)" where the error knows no single file.
std::string FileText(const InputName& input, const std::vector<std::string>& texts) {
  std::vector<std::string> paths;
  for (const std::string& text : texts) {
    if (text.starts_with(input.port + '=')) paths.push_back(text.substr(input.port.size() + 1));
  }
  if (paths.empty()) return input.port;
  if (input.index && *input.index < paths.size()) return paths[*input.index];
  if (paths.size() == 1) return paths[0];
  return fmt::format("{} (or another of {})", paths[0], paths.size());
}

}  // namespace

std::string NameFiles(const InputError& error, const std::vector<std::string>& texts) {
  std::string files;
  for (const InputName& input : error.Inputs()) {
    files += (files.empty() ? "" : ", ") + FileText(input, texts);
  }
  std::string text = files + ": " + error.Text();
  if (error.WhichRemedy() == InputError::Remedy::kDelete) {
    const char* which = error.Inputs().size() == 1 ? "it" : "them";
    text += fmt::format("; delete {} and run make again", which);
  }
  return text;
}

}  // namespace nightmap
