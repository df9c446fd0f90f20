// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/pose_arrays.h"

#include <cmath>

#include "pipeline/base/error.h"

namespace nightmap {

void AppendPose(const Rigid3& pose, Array<double>* array) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  array->values.insert(array->values.end(), {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  array->cols = 7;
  ++array->rows;
}

Rigid3 PoseAt(const Array<double>& array, std::size_t row, const std::filesystem::path& path) {
  const double* v = array.values.data() + row * 7;
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (std::abs(rotation.norm() - 1) > 1e-6) {
    throw DataError(
        "{}: row {} holds a quaternion that is not of unit length; delete the file and "
        "run make",
        path.string(),
        row);
  }
  return {rotation, {v[0], v[1], v[2]}};
}

void AppendCovariance(const Matrix6d& covariance, Array<double>* array) {
  array->values.insert(array->values.end(), covariance.data(), covariance.data() + 36);
  array->cols = 36;
  ++array->rows;
}

Matrix6d CovarianceAt(const Array<double>& array, std::size_t row) {
  return Eigen::Map<const Matrix6d>(array.values.data() + row * 36);
}

}  // namespace nightmap
