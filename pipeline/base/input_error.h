// SPDX-License-Identifier: Apache-2.0
// Content of inputs that cannot be, found by code that knows no file.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/error.h"

namespace nightmap {

struct InputName {
  std::string port;
  std::optional<std::size_t> index = {};  // of the file, where the port takes several
};

// One of `inputs` is damaged or of another run. The message begins with their names, "odometry[2]";
// RunStage puts their files in place of that, and the remedy, to delete them, at the end.
class InputError : public DataError {
 public:
  template <typename... Args>
  InputError(std::vector<InputName> inputs, fmt::format_string<Args...> format, Args&&... args)
      : InputError(std::move(inputs), Formatted{fmt::format(format, std::forward<Args>(args)...)}) {
  }

  const std::vector<InputName>& Inputs() const { return inputs_; }
  const std::string& Text() const { return text_; }

 private:
  struct Formatted {  // so that no arguments of a caller choose the constructor below
    std::string text;
  };
  InputError(std::vector<InputName> inputs, Formatted formatted)
      : DataError("{}: {}", Names(inputs), formatted.text),
        inputs_(std::move(inputs)),
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
  std::string text_;
};

}  // namespace nightmap
