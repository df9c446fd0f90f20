// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/search_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

namespace nightmap {
namespace {

// Shifts of one heading: a square of 2^level x 2^level cells from (column, row) on.
struct Square {
  double bound = 0;  // of the value of its shifts; of a single shift its value
  int level = 0;
  int turn = 0;
  int column = 0;
  int row = 0;
};

// The largest bound first; of equal ones by place, so that the order does not matter.
void SortByBound(std::vector<Square>* squares) {
  std::ranges::sort(*squares, [](const Square& a, const Square& b) {
    return std::tie(b.bound, a.turn, a.row, a.column) < std::tie(a.bound, b.turn, b.row, b.column);
  });
}

constexpr std::size_t kBatch = 16;   // points that are looked up before the next check
constexpr std::size_t kStride = 16;  // so that a batch has points of all sides

constexpr double kTooSmall = -std::numeric_limits<double>::infinity();

// The same points in another order: each kStride-th, from the first on, then from the second on.
std::vector<Eigen::Vector2d> Interleaved(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> result;
  result.reserve(points.size());
  for (std::size_t first = 0; first < kStride; ++first) {
    for (std::size_t i = first; i < points.size(); i += kStride) result.push_back(points[i]);
  }
  return result;
}

// Distance of the nearest of the cells [first, last] from 0.
double Nearest(int first, int last) { return std::max({0, first, -last}); }

class PoseSearch {
 public:
  PoseSearch(const FieldPyramid& pyramid,
             const std::vector<Eigen::Vector2d>& points,
             const SearchWindow& window,
             double share)
      : pyramid_(pyramid),
        window_(window),
        points_(Interleaved(points)),
        cell_m_(pyramid.Field().Resolution_m()),
        headings_(HeadingStepsOf(window, cell_m_, points)),
        num_shifts_(static_cast<int>(std::ceil(window.half_extent_m / cell_m_))),
        center_cell_(
            pyramid.Field().ToCells(window.center.translation).array().round().cast<int>()),
        share_(share),
        least_(window.min_value) {}

  // Poses that were the best, or at least `share_` of the best, when they were found.
  std::vector<FoundPose> Run() {
    if (points_.empty()) return {};
    std::vector<Square> squares;
    for (int turn = -headings_.num_turns; turn <= headings_.num_turns; ++turn) {
      cells_.push_back(CellsOf(Pose(turn, 0, 0)));
      AddSquares(turn, &squares);
    }
    Explore(&squares);
    return found_;
  }

 private:
  Rigid2 Pose(int turn, int column, int row) const {
    return {window_.center.heading_rad + turn * headings_.step_rad,
            window_.center.translation + cell_m_ * Eigen::Vector2d(column, row)};
  }

  std::vector<Eigen::Vector2i> CellsOf(const Rigid2& pose) const {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(pose.heading_rad).toRotationMatrix();
    std::vector<Eigen::Vector2i> cells;
    cells.reserve(points_.size());
    for (const Eigen::Vector2d& point : points_) {
      const Eigen::Vector2d cell = pyramid_.Field().ToCells(turn * point + pose.translation);
      cells.push_back(cell.array().round().cast<int>());
    }
    return cells;
  }

  // The whole window of a heading, in squares of the highest level that is not larger.
  void AddSquares(int turn, std::vector<Square>* squares) const {
    int level = pyramid_.NumLevels() - 1;
    while (level > 0 && (1 << level) > 2 * num_shifts_ + 1) --level;
    const int side = 1 << level;
    for (int row = -num_shifts_; row <= num_shifts_; row += side) {
      for (int column = -num_shifts_; column <= num_shifts_; column += side) {
        Add({0, level, turn, column, row}, squares);
      }
    }
  }

  std::vector<Square> Parts(const Square& square) const {
    const int half = 1 << (square.level - 1);
    std::vector<Square> parts;
    for (const int row : {square.row, square.row + half}) {
      for (const int column : {square.column, square.column + half}) {
        if (row > num_shifts_ || column > num_shifts_) continue;
        Add({0, square.level - 1, square.turn, column, row}, &parts);
      }
    }
    return parts;
  }

  // The likely ones first, so that what is found there spares the others.
  void Explore(std::vector<Square>* squares) {
    SortByBound(squares);
    for (const Square& square : *squares) {
      if (square.bound <= least_) return;
      if (square.level == 0) {
        found_.push_back(Found(square));
        least_ = std::max(least_, share_ * square.bound);
      } else {
        std::vector<Square> parts = Parts(square);
        Explore(&parts);
      }
    }
  }

  void Add(Square square, std::vector<Square>* squares) const {
    const int last_column = std::min(square.column + (1 << square.level) - 1, num_shifts_);
    const int last_row = std::min(square.row + (1 << square.level) - 1, num_shifts_);
    if (!IsPlace(square) || IsLeftOut(square, last_column, last_row)) return;
    const double shift_m =
        cell_m_ * std::hypot(Nearest(square.column, last_column), Nearest(square.row, last_row));
    const double turn_rad = square.turn * headings_.step_rad;
    const double penalty =
        window_.penalty_per_m2 * shift_m * shift_m + window_.penalty_per_rad2 * turn_rad * turn_rad;
    square.bound = Score(square, least_ + penalty) - penalty;
    if (square.bound > least_) squares->push_back(square);
  }

  // The mean of the square's cells at the points; kTooSmall as soon as it must be at most `least`.
  double Score(const Square& square, double least) const {
    const auto& cells = cells_[static_cast<std::size_t>(square.turn + headings_.num_turns)];
    const double scale = 255.0 * static_cast<double>(cells.size());
    // Points that are still to come may all be 1.
    const double least_sum = least * scale;
    int sum = 0;
    double rest = scale;
    for (std::size_t first = 0; first < cells.size(); first += kBatch) {
      const std::size_t end = std::min(first + kBatch, cells.size());
      for (std::size_t i = first; i < end; ++i) {
        sum += pyramid_.At(square.level, cells[i].x() + square.column, cells[i].y() + square.row);
      }
      rest -= 255.0 * static_cast<double>(end - first);
      if (sum + rest <= least_sum) return kTooSmall;
    }
    return sum / scale;
  }

  bool IsPlace(const Square& square) const {
    return window_.places == nullptr ||
           window_.places->At(
               square.level, center_cell_.x() + square.column, center_cell_.y() + square.row) > 0;
  }

  bool IsLeftOut(const Square& square, int last_column, int last_row) const {
    if (!window_.not_near) return false;
    const Rigid2 pose = Pose(square.turn, 0, 0);
    if (std::abs(WrapAngle_rad(pose.heading_rad - window_.not_near->heading_rad)) >
        window_.near_rad) {
      return false;
    }
    const Eigen::Vector2d first =
        (window_.not_near->translation - window_.center.translation) / cell_m_;
    const Eigen::Vector2d far(
        std::max(std::abs(square.column - first.x()), std::abs(last_column - first.x())),
        std::max(std::abs(square.row - first.y()), std::abs(last_row - first.y())));
    return cell_m_ * far.norm() <= window_.near_m;
  }

  FoundPose Found(const Square& square) const {
    return {Pose(square.turn, square.column, square.row), Score(square, kTooSmall), square.bound};
  }

  const FieldPyramid& pyramid_;
  const SearchWindow& window_;
  std::vector<Eigen::Vector2d> points_;
  double cell_m_;
  HeadingSteps headings_;
  int num_shifts_;
  Eigen::Vector2i center_cell_;
  std::vector<std::vector<Eigen::Vector2i>> cells_;  // of the points, by turn
  double share_;
  double least_;  // what is not above it is not looked for
  std::vector<FoundPose> found_;
};

}  // namespace

HeadingSteps HeadingStepsOf(const SearchWindow& window,
                            double resolution_m,
                            const std::vector<Eigen::Vector2d>& points_in_robot) {
  double sum_m2 = 0;
  for (const Eigen::Vector2d& point : points_in_robot) sum_m2 += point.squaredNorm();
  const double count = static_cast<double>(std::max<std::size_t>(1, points_in_robot.size()));
  const double distance_m = std::max(resolution_m, std::sqrt(sum_m2 / count));
  const double step_rad = kHeadingStep_cells * resolution_m / distance_m;
  const double half_angle_rad = std::min(window.half_angle_rad, std::numbers::pi);
  return {static_cast<int>(std::ceil(half_angle_rad / step_rad)), step_rad};
}

std::optional<FoundPose> SearchPose(const FieldPyramid& pyramid,
                                    const std::vector<Eigen::Vector2d>& points_in_robot,
                                    const SearchWindow& window) {
  const auto found = PoseSearch(pyramid, points_in_robot, window, 1).Run();
  if (found.empty()) return std::nullopt;
  return found.back();
}

std::vector<FoundPose> SearchPoses(const FieldPyramid& pyramid,
                                   const std::vector<Eigen::Vector2d>& points_in_robot,
                                   const SearchWindow& window,
                                   double share_of_best) {
  auto found = PoseSearch(pyramid, points_in_robot, window, share_of_best).Run();
  std::ranges::stable_sort(found, std::greater(), &FoundPose::value);
  const auto is_less = [&](const FoundPose& pose) {
    return pose.value < share_of_best * found.front().value;
  };
  found.erase(std::ranges::find_if(found, is_less), found.end());
  return found;
}

}  // namespace nightmap
