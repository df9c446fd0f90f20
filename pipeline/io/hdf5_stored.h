// SPDX-License-Identifier: Apache-2.0
// Values as elements of a row of an HDF5 array: numbers, flags, poses, vectors and matrices.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

template <typename T, typename Number>
struct StoredAsNumber {
  using Element = Number;
  static constexpr std::size_t kWidth = 1;
  static void Put(T value, std::vector<Element>* to) { to->push_back(static_cast<Element>(value)); }
  static void Take(const Element* from, T* value) { *value = static_cast<T>(*from); }
};

template <typename T, typename Number, std::size_t size>
struct StoredAsNumbers {
  using Element = Number;
  static constexpr std::size_t kWidth = size;
  static void Put(const T& values, std::vector<Element>* to) {
    to->insert(to->end(), values.data(), values.data() + size);
  }
  static void Take(const Element* from, T* values) { std::copy_n(from, size, values->data()); }
};

template <typename T>
struct Stored : StoredAsNumber<T, T> {};

template <typename T>
requires std::is_enum_v<T>
struct Stored<T> : StoredAsNumber<T, std::underlying_type_t<T>> {
};

template <>
struct Stored<bool> : StoredAsNumber<bool, std::uint8_t> {
  static bool IsOne(const Element* from) { return *from <= 1; }
  static constexpr std::string_view kOtherwise = "a flag that is neither 0 nor 1";
};

template <typename T, std::size_t size>
struct Stored<std::array<T, size>> : StoredAsNumbers<std::array<T, size>, T, size> {};

// Column by column.
template <typename T, int rows, int cols>
struct Stored<Eigen::Matrix<T, rows, cols>>
    : StoredAsNumbers<Eigen::Matrix<T, rows, cols>, T, std::size_t{rows * cols}> {};

// tx ty tz (metres) qx qy qz qw (unit quaternion).
template <>
struct Stored<Rigid3> {
  using Element = double;
  static constexpr std::size_t kWidth = 7;
  static void Put(const Rigid3& pose, std::vector<double>* to) {
    Stored<Eigen::Vector3d>::Put(pose.translation, to);
    Stored<Eigen::Vector4d>::Put(pose.rotation.coeffs(), to);
  }
  static void Take(const double* from, Rigid3* pose) {
    *pose = {Eigen::Quaterniond(from + 3), Eigen::Vector3d(from)};
  }
  static bool IsOne(const double* from) {
    return std::abs(Eigen::Quaterniond(from + 3).norm() - 1) <= 1e-6;
  }
  static constexpr std::string_view kOtherwise = "a quaternion that is not of unit length";
};

}  // namespace nightmap
