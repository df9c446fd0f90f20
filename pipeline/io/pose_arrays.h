// SPDX-License-Identifier: Apache-2.0
// Poses and covariances as rows of HDF5 arrays.
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/hdf5_file.h"

namespace nightmap {

// A row is tx ty tz qx qy qz qw (metres, unit quaternion).
void AppendPose(const Rigid3& pose, Array<double>* array);
// Throws DataError naming the file when the quaternion is not of unit length.
Rigid3 PoseAt(const Array<double>& array, std::size_t row, const std::filesystem::path& path);

// A row is the 36 entries of the matrix.
void AppendCovariance(const Matrix6d& covariance, Array<double>* array);
Matrix6d CovarianceAt(const Array<double>& array, std::size_t row);

}  // namespace nightmap
