// SPDX-License-Identifier: Apache-2.0
// Nothing: the headers that CMake puts before each test are compiled with it (cmake/tests.cmake).
