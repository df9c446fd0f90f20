// SPDX-License-Identifier: Apache-2.0
// Content of inputs that cannot be.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/error.h"

namespace nightmap {

// An artifact is damaged, or does not fit the others. Unlike what is wrong with one picture
// (FrameFailure), it ends the stage wherever it is found: what is made without it would pass for
// good, and a rerun makes the artifact anew. The message names the file.
struct ArtifactError : DataError {
  using DataError::DataError;
};

struct InputName {
  std::string port;
  std::optional<std::size_t> index = {};  // of the file, where the port takes several
};

// `inputs` cannot be used together or at all, found by code that knows no file. The message begins
// with their names, "odometry[2]"; RunStage puts their files in place of that. Who throws it
// chooses: a file that is damaged or of another run is made anew when it is deleted, which RunStage
// tells at the end; what is whole but was made of the wrong recording is not, so that the text has
// its own remedy.
class InputError : public ArtifactError {
 public:
  template <typename... Args>
  InputError(std::vector<InputName> inputs, fmt::format_string<Args...> format, Args&&... args)
      : InputError(std::move(inputs), Remedy::kDelete, format, std::forward<Args>(args)...) {}

  enum class Remedy { kDelete, kInText };
  template <typename... Args>
  InputError(std::vector<InputName> inputs,
             Remedy remedy,
             fmt::format_string<Args...> format,
             Args&&... args)
      : InputError(std::move(inputs),
                   remedy,
                   Formatted{fmt::format(format, std::forward<Args>(args)...)}) {}

  const std::vector<InputName>& Inputs() const { return inputs_; }
  const std::string& Text() const { return text_; }
  Remedy WhichRemedy() const { return remedy_; }

 private:
  struct Formatted {  // so that no arguments of a caller choose the constructor below
    std::string text;
  };
  InputError(std::vector<InputName> inputs, Remedy remedy, Formatted formatted)
      : ArtifactError("{}: {}", Names(inputs), formatted.text),
        inputs_(std::move(inputs)),
        remedy_(remedy),
        text_(std::move(formatted.text)) {}

  static std::string Names(const std::vector<InputName>& inputs) {
    std::string names;
    for (const InputName& input : inputs) {
      names += (names.empty() ? "" : ", ") + input.port;
      if (input.index) names += fmt::format("[{}]", *input.index);
    }
    return names;
  }

  std::vector<InputName> inputs_;
  Remedy remedy_;
  std::string text_;
};

}  // namespace nightmap
