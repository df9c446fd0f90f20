// SPDX-License-Identifier: Apache-2.0
// The main of every test program. CMake compiles the headers that it puts before each test with it
// (cmake/tests.cmake).
#include <gmock/gmock.h>

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
