// SPDX-License-Identifier: Apache-2.0
// Shared by tests: real recordings, scratch folders, and checks of error messages.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/progress.h"

namespace nightmap {

// A recording of the data folder: $NIGHTMAP_DATA, or ../shared/data next to the source folder
// (where CTest runs the tests).
inline std::filesystem::path TestDataPath(const std::string& name) {
  const char* folder = std::getenv("NIGHTMAP_DATA");
  return std::filesystem::path(folder ? folder : "../shared/data") / name;
}

inline bool IsContinuousIntegration() {
  const char* ci = std::getenv("CI");
  return ci && std::string(ci) == "true";
}

// Tests that take long and try one thing again, as on another seed or building, are left to the
// night: `make test-nightly` sets NIGHTMAP_NIGHTLY=1.
inline bool IsNight() {
  const char* nightly = std::getenv("NIGHTMAP_NIGHTLY");
  return nightly && std::string(nightly) == "1";
}

// All at night, the first by day.
template <typename T>
std::vector<T> AllAtNight(std::vector<T> all) {
  if (!IsNight()) all.resize(1);
  return all;
}

// First line of a test that needs a real recording. Recordings are hundreds of megabytes and not in
// the repository (datasets.md names their sources), so the test is skipped without them and prints
// the remedy. In CI it fails instead, because a silent skip would look like a pass.
#define NIGHTMAP_REQUIRE_DATA(name)                                                     \
  if (!std::filesystem::exists(::nightmap::TestDataPath(name))) {                       \
    if (::nightmap::IsContinuousIntegration()) {                                        \
      FAIL() << ::nightmap::TestDataPath(name) << " is missing: set NIGHTMAP_DATA";     \
    }                                                                                   \
    GTEST_SKIP() << ::nightmap::TestDataPath(name) << " is missing: set NIGHTMAP_DATA"; \
  }                                                                                     \
  static_assert(true, "")

// An empty folder for one test, removed after it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "." + test->name();
    for (char& c : name) c = c == '/' ? '_' : c;
    path_ = std::filesystem::path(testing::TempDir()) /
            ("nightmap_" + name + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& Path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

  // Writes a file, its folders made as needed, and returns its path.
  std::filesystem::path Write(const std::filesystem::path& name, const std::string& bytes) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

// Tests that write files.
class InFolder : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

// Shows nothing.
inline Progress& NoProgress() {
  static Progress progress("test", false);
  return progress;
}

inline std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Expects `statement` to throw ErrorType with a message that contains each of the texts.
#define NIGHTMAP_EXPECT_ERROR(ErrorType, statement, ...)                                     \
  try {                                                                                      \
    (void)(statement);                                                                       \
    ADD_FAILURE() << #statement << " threw nothing";                                         \
  } catch (const ErrorType& error) {                                                         \
    for (const std::string& expected_part : std::initializer_list<std::string>{__VA_ARGS__}) \
      EXPECT_THAT(std::string(error.what()), testing::HasSubstr(expected_part));             \
  }                                                                                          \
  static_assert(true, "")

}  // namespace nightmap
