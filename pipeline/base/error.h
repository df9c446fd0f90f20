// SPDX-License-Identifier: Apache-2.0
// Errors that end a stage, each with its exit code.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace nightmap {

enum class ExitCode {
  kOk = 0,              // outputs are committed
  kDataError = 1,       // data, I/O or numeric failure
  kUsageError = 2,      // command line or config error
  kBelowThreshold = 3,  // ran, but below a stated acceptance threshold; commits nothing
};

// Base of the three errors below. The message names the file (or option) and the remedy.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode Code() const { return code_; }

 private:
  ExitCode code_;
};

struct DataError : Error {
  template <typename... Args>
  explicit DataError(fmt::format_string<Args...> format, Args&&... args)
      : Error(ExitCode::kDataError, fmt::format(format, std::forward<Args>(args)...)) {}
};

struct UsageError : Error {
  template <typename... Args>
  explicit UsageError(fmt::format_string<Args...> format, Args&&... args)
      : Error(ExitCode::kUsageError, fmt::format(format, std::forward<Args>(args)...)) {}
};

struct ThresholdError : Error {
  template <typename... Args>
  explicit ThresholdError(fmt::format_string<Args...> format, Args&&... args)
      : Error(ExitCode::kBelowThreshold, fmt::format(format, std::forward<Args>(args)...)) {}
};

}  // namespace nightmap
