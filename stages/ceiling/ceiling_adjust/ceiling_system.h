// SPDX-License-Identifier: Apache-2.0
// Damped normal equations of the adjustment below a ceiling, the points eliminated one after the
// other (Triggs et al., Bundle Adjustment, 1999). Nothing is kept per sighting: errors are
// linearized again where the points' steps need them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/ceiling/ceiling_noise.h"
#include "pipeline/geometry/block_pattern.h"
#include "pipeline/geometry/index_groups.h"
#include "pipeline/geometry/sparse_cholesky.h"
#include "stages/ceiling/ceiling_adjust/ceiling_errors.h"
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"
#include "stages/ceiling/ceiling_adjust/keyframe_tree.h"

namespace nightmap {

// Views of all keyframes.
std::vector<KeyframeView> ViewsOf(const CeilingProblem& problem, const CeilingUnknowns& unknowns);

class CeilingSystem {
 public:
  // Keeps references. `neighbours`: see FindNeighbours. Throws DataError when the system is too
  // large.
  CeilingSystem(const CeilingNoise& noise,
                const CeilingProblem& problem,
                const IndexGroups& sightings_of_point,
                const std::vector<std::vector<int>>& neighbours,
                std::size_t num_points);

  // The step of the errors linearized at `unknowns` under the losses' weights there, all unknowns
  // damped by `damping` times their own curvature. Nothing where the system is not positive
  // definite. Throws DataError when its factor does not fit into memory. Deterministic; one thread.
  std::optional<CeilingStep> Step(const CeilingUnknowns& unknowns,
                                  const CauchyLoss& sighting_loss,
                                  double damping);

 private:
  static constexpr int kSize = 5;  // of a keyframe
  static constexpr int kCommon = kNumCommon;
  using Matrix5d = Eigen::Matrix<double, 5, 5>;
  using Matrix53d = Eigen::Matrix<double, 5, 3>;
  using Matrix3Common = Eigen::Matrix<double, 3, kCommon>;
  using CommonMatrix = Eigen::Matrix<double, kCommon, kCommon>;
  using CommonVector = Eigen::Matrix<double, kCommon, 1>;

  struct Estimate {
    const CeilingUnknowns& unknowns;
    const std::vector<KeyframeView>& views;
    const CauchyLoss& loss;
    double damping;
  };

  // A point with all that couples it.
  struct Point {
    Eigen::Matrix3d inverse;  // of its damped curvature
    Eigen::Vector3d gradient;
    Matrix3Common by_common;
    struct Seen {
      std::size_t keyframe;
      Matrix53d by_point;
    };
    std::vector<Seen> seen;  // by keyframe, each once
  };

  int RankOf(std::size_t keyframe) const { return pattern_.rank[keyframe]; }
  Eigen::Map<Eigen::MatrixXd> ColumnsOf(std::size_t keyframe);
  Eigen::Map<CommonMatrix> CommonBlock();
  Eigen::Index BlockRow(std::size_t earlier, int later_rank, Eigen::Index first);

  void Clear();
  template <int kRows>
  void Add(std::size_t keyframe,
           double weight,
           const Eigen::Matrix<double, kRows, kSize>& by_keyframe,
           const Eigen::Matrix<double, kRows, kCommon>& by_common,
           const Eigen::Matrix<double, kRows, 1>& residual);
  template <int kRows>
  void AddCommon(double weight,
                 const Eigen::Matrix<double, kRows, kCommon>& by_common,
                 const Eigen::Matrix<double, kRows, 1>& residual);
  void AddMotions(const CeilingUnknowns& unknowns);
  void AddExpected(const CeilingUnknowns& unknowns);
  // `is_new`: also adds what the point's errors say of all others.
  void LoadPoint(const Estimate& estimate, std::size_t index, bool is_new);
  void AddLevel(const CeilingUnknowns& unknowns,
                std::size_t index,
                bool is_new,
                Eigen::Matrix3d* curvature);
  void EliminatePoint();
  void Damp(double damping);
  CeilingStep StepOf(const Estimate& estimate, const Eigen::VectorXd& solution);

  const CeilingNoise& noise_;
  const CeilingProblem& problem_;
  const IndexGroups& of_point_;
  std::vector<bool> is_level_;  // by point
  BlockPattern pattern_;
  Eigen::VectorXd curvature_, gradient_;  // of keyframes by rank, then of what they share
  Eigen::VectorXd eliminated_;            // of the gradient, with the points
  double expected_gain_ = 0;              // of the points alone
  Point point_;                           // the last one loaded
  SparseCholesky cholesky_;
};

}  // namespace nightmap
