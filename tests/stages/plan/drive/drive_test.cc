// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/drive.h"

#include <cmath>
#include <sstream>

#include "stages/plan/drive/drive_output.h"
#include "stages/plan/drive/gif_io.h"
#include "tests/stages/plan/drive/hall.h"
#include "tests/stages/plan/drive/random_path.h"

namespace nightmap::drive_test {

void ExpectWithinLimits(const DriveResult& result, const MotionLimits& limits) {
  Twist last;
  for (const DriveStep& step : result.steps) {
    const Twist& now = step.command;
    EXPECT_GE(now.v_m_s, 0);
    EXPECT_LE(now.v_m_s, limits.max_v_m_s + 1e-12);
    EXPECT_LE(std::abs(now.omega_rad_s), limits.max_omega_rad_s + 1e-12);
    EXPECT_LE(std::abs(now.v_m_s - last.v_m_s),
              limits.max_acceleration_m_s2 * limits.period_s + 1e-12);
    EXPECT_LE(std::abs(now.omega_rad_s - last.omega_rad_s),
              limits.max_angular_acceleration_rad_s2 * limits.period_s + 1e-12);
    last = now;
  }
  EXPECT_TRUE(last.IsRest());
}

// Replays like a controller that knows only drive.csv: the rows' commands from the first row's
// pose.
void ExpectReplay(const DriveResult& result) {
  std::istringstream csv(DriveToCsv(result));
  std::string line;
  std::getline(csv, line);
  ASSERT_EQ(line, "time_ns,x_m,y_m,heading_rad,v_m_s,omega_rad_s");
  PlanarPose replayed = result.steps[0].pose;
  std::int64_t last_ns = 0;
  Twist command;
  std::size_t num_rows = 0;
  while (std::getline(csv, line)) {
    std::array<double, 6> row{};
    std::istringstream fields(line);
    for (double& value : row) {
      std::string field;
      ASSERT_TRUE(std::getline(fields, field, ','));
      value = std::stod(field);
    }
    const auto time_ns = static_cast<std::int64_t>(row[0]);
    replayed = Advance(replayed, command, 1e-9 * static_cast<double>(time_ns - last_ns));
    last_ns = time_ns;
    EXPECT_NEAR(replayed.point_in_map.x(), row[1], 1e-6);
    EXPECT_NEAR(replayed.point_in_map.y(), row[2], 1e-6);
    EXPECT_NEAR(WrapAngle(replayed.heading_rad - row[3]), 0, 1e-6);
    command = {row[4], row[5]};
    ++num_rows;
  }
  EXPECT_EQ(num_rows, result.steps.size());
}

DriveOptions WithHeadings(const std::string& start_deg, const std::string& goal_deg) {
  DriveOptions options;
  options.start_heading_deg = start_deg;
  options.goal_heading_deg = goal_deg;
  return options;
}

DriveOptions DrawOptions(Random& random) {
  const std::string start_deg = std::to_string(random.Uniform(-180, 180));
  DriveOptions options = WithHeadings(start_deg, std::to_string(random.Uniform(-180, 180)));
  MotionLimits& limits = options.controller.limits;
  limits.max_v_m_s = random.Uniform(0.2, 1.5);
  limits.max_omega_rad_s = random.Uniform(0.4, 2);
  limits.max_acceleration_m_s2 = random.Uniform(0.2, 2);
  limits.max_angular_acceleration_rad_s2 = random.Uniform(0.5, 5);
  limits.period_s = random.Uniform(0.01, 0.1);
  return options;
}

// The bar of the stage: 5 cm and 5 degrees, no collision, on 200 paths, some of which touch.
TEST(Drive, ArrivesOnRandomPathsWithinTheLimitsAndClearOfObstacles) {
  int num_drives = 0;
  int num_tight = 0;
  for (std::uint64_t seed = 0; num_drives < 200; ++seed) {
    Random random(seed);
    DriveInputs inputs{RandomBuilding(random), {}};
    const RandomPaths paths(inputs.grid, kRadius_m);
    const ObstacleDistances distances(inputs.grid, true, 1);
    const DriveOptions options = DrawOptions(random);
    for (int i = 0; i < 4 && num_drives < 200; ++i) {
      inputs.path = {{paths.Draw(random)}, 0, kRadius_m, false};
      const auto& points = inputs.path.legs_in_map[0];
      if (points.empty()) continue;
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", path " << i);
      const DriveResult result = Drive(options, inputs);
      ++num_drives;
      ExpectWithinLimits(result, options.controller.limits);
      const PlanarPose& last = result.steps.back().pose;
      EXPECT_LE((last.point_in_map - points.back()).norm(), 0.05);
      const double turn_rad = last.heading_rad - std::stod(options.goal_heading_deg) * kDegrees;
      EXPECT_LE(std::abs(WrapAngle(turn_rad)), 5 * kDegrees);
      EXPECT_EQ(result.steps[0].pose.point_in_map, points[0]);
      EXPECT_GE(result.min_clearance_m, kRadius_m - 1e-5);
      num_tight += paths.Room_m(points) < 0.005 ? 1 : 0;
      if (num_drives % 20 == 0) ExpectReplay(result);  // which is slow
      for (const DriveStep& step : result.steps) {
        EXPECT_GE(distances.Clearance_m(inputs.grid.ToCells(step.pose.point_in_map)),
                  kRadius_m - 1e-5);
      }
    }
  }
  EXPECT_GT(num_tight, 50);
}

// The hall with a wall beside the path, rotated in the map by the yaw of its origin: the same
// drive. With the wall on the path: the same collision.
TEST(Drive, FollowsAGridThatIsTurned) {
  DriveInputs inputs = Hall();
  FillCells(30, 28, 70, 30, kOccupiedCell, &inputs.grid);
  const DriveResult straight = Drive({}, inputs);
  const Eigen::Rotation2Dd turn(0.7);
  inputs.grid.origin_yaw_rad = turn.angle();
  for (auto& point : inputs.path.legs_in_map[0]) point = turn * point;
  inputs.path.goal_heading_rad += turn.angle();
  const DriveResult turned = Drive({}, inputs);
  EXPECT_NEAR(turned.min_clearance_m, straight.min_clearance_m, 1e-3);
  const Eigen::Vector2d goal = turn * Eigen::Vector2d(4, 5);
  EXPECT_LT((turned.steps.back().pose.point_in_map - goal).norm(), 0.05);
  FillCells(30, 18, 70, 22, kOccupiedCell, &inputs.grid);
  EXPECT_THROW(Drive({}, inputs), ThresholdError);
}

TEST(Drive, TurnsInPlaceAtBothEnds) {
  const DriveResult result = Drive(WithHeadings("180", "-45"), Hall());
  const DriveStep& first =
      *std::ranges::find_if(result.steps, [](const auto& step) { return step.command.v_m_s > 0; });
  EXPECT_EQ(first.pose.point_in_map, Eigen::Vector2d(1, 1));
  EXPECT_LT(std::abs(first.pose.heading_rad), 5 * kDegrees);
  EXPECT_NEAR(result.steps.back().pose.heading_rad, -45 * kDegrees, 1e-3);
  EXPECT_LT(result.heading_error_deg, 0.1);
  ExpectReplay(result);
}

TEST(Drive, HeadingsComeFromThePathUnlessAsked) {
  const DriveResult result = Drive({}, Hall());
  EXPECT_EQ(result.steps[0].pose.heading_rad, 0);
  EXPECT_NEAR(result.steps.back().pose.heading_rad, 90 * kDegrees, 1e-3);
}

TEST(Drive, ReachesFullSpeedAndCutsNoMoreThanItSees) {
  const DriveResult result = Drive({}, Hall());
  double fastest_m_s = 0;
  for (const DriveStep& step : result.steps) {
    fastest_m_s = std::max(fastest_m_s, step.command.v_m_s);
  }
  EXPECT_EQ(fastest_m_s, 0.5);
  EXPECT_GT(result.max_deviation_m, 0.01);  // the corner
  EXPECT_LT(result.max_deviation_m, 0.3);
  EXPECT_LT(result.length_m, result.path_length_m);
  EXPECT_GT(result.length_m, std::hypot(3, 4));
}

TEST(Drive, IsSlowerWhereItIsNarrow) {
  const DriveInputs wide = Hall();
  DriveInputs narrow = wide;
  FillCells(30, 0, 70, 15, kOccupiedCell, &narrow.grid);   // 0.25 m below the first leg
  FillCells(30, 25, 70, 30, kOccupiedCell, &narrow.grid);  // and above
  EXPECT_GT(Drive({}, narrow).Duration_s(), 1.1 * Drive({}, wide).Duration_s());
}

TEST(Drive, StandsWhereItIsToStand) {
  DriveInputs inputs = Hall();
  inputs.path.legs_in_map = {{{1, 1}}};
  const DriveResult result = Drive(WithHeadings("10", ""), inputs);
  EXPECT_EQ(result.length_m, 0);
  EXPECT_NEAR(result.steps.back().pose.heading_rad, 90 * kDegrees, 1e-3);
}

// There and back on the same line: none may be passed over.
TEST(Drive, StopsAtEachGoal) {
  DriveInputs inputs = Hall();
  inputs.path.legs_in_map = {{{1, 1}, {4, 1}}, {{4, 1}, {1, 1}}, {{1, 1}, {1, 4}}};
  const DriveResult result = Drive({}, inputs);
  EXPECT_EQ(result.num_goals, 3U);
  std::vector<Eigen::Vector2d> stops;
  for (const DriveStep& step : result.steps) {
    const Eigen::Vector2d& point = step.pose.point_in_map;
    const bool is_new = stops.empty() || (stops.back() - point).norm() > 0.1;
    if (step.command.IsRest() && is_new) stops.push_back(point);
  }
  ASSERT_EQ(stops.size(), 3U);
  EXPECT_LT((stops[0] - Eigen::Vector2d(4, 1)).norm(), 0.001);
  EXPECT_LT((stops[1] - Eigen::Vector2d(1, 1)).norm(), 0.001);
  EXPECT_LT((stops[2] - Eigen::Vector2d(1, 4)).norm(), 0.001);
  ExpectWithinLimits(result, MotionLimits{});
  ExpectReplay(result);
}

TEST(Drive, OwnRadiusGoesBeforeThePlanned) {
  DriveInputs inputs = Hall();
  FillCells(60, 0, 70, 13, kOccupiedCell, &inputs.grid);  // 0.35 m below the first leg
  DriveOptions options;
  EXPECT_EQ(Drive(options, inputs).footprint.radius_m, kRadius_m);
  options.robot_radius_m = 0.3;
  EXPECT_GE(Drive(options, inputs).min_clearance_m, 0.3 - 1e-5);
}

TEST(Drive, DrivesThroughUnknownSpaceOnlyWhenThePathMay) {
  DriveInputs inputs = Hall();
  FillCells(40, 20, 50, 21, kUnknownCell, &inputs.grid);
  DriveOptions options;
  options.max_duration_s = 60;
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Drive(options, inputs), "not arrived");
  inputs.path.may_cross_unknown = true;
  EXPECT_LT(Drive({}, inputs).position_error_m, 0.05);
}

// It stops before a wall that is newer than the path.
TEST(DriveErrors, BlockedPathIsNotArrivedAt) {
  DriveInputs inputs = Hall();
  FillCells(0, 60, 120, 62, kOccupiedCell, &inputs.grid);
  DriveOptions options;
  options.max_duration_s = 100;
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Drive(options, inputs), "max_duration_s", "from the goal");
}

TEST(DriveErrors, StartInAnObstacleCollides) {
  DriveInputs inputs = Hall();
  FillCells(22, 18, 30, 24, kOccupiedCell, &inputs.grid);
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Drive({}, inputs), "collides after 0.00 s at 1.000,1.000");
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Drive({}, inputs), "make plan");
}

// Each of these paths once crashed, did not end, or led outside the map.
TEST(DriveErrors, PathThatIsNotOnTheGrid) {
  for (const Eigen::Vector2d& shift :
       {Eigen::Vector2d(2.2, 0), {0, -1.1}, {1e6, 1e6}, {1e300, 0}}) {
    for (const bool may_cross_unknown : {false, true}) {
      DriveInputs inputs = Hall();
      inputs.path.may_cross_unknown = may_cross_unknown;
      for (auto& point : inputs.path.legs_in_map[0]) point += shift;
      NIGHTMAP_EXPECT_ERROR(DataError,
                            Drive({}, inputs),
                            "the path is not on this grid",
                            "spans 0.000,0.000 to 6.000,6.000");
    }
  }
  DriveInputs inputs = Hall();
  inputs.path.legs_in_map = {{{1, 1}, {4, 1}}, {{4, 1}, {4, 5}, {1e6, 5}}};
  NIGHTMAP_EXPECT_ERROR(DataError, Drive({}, inputs), "csv: line 5: the path");
  inputs = Hall();
  inputs.grid.origin_in_map = {1e9, 1e9};
  NIGHTMAP_EXPECT_ERROR(DataError, Drive({}, inputs), "1.000,1.000 is outside");
}

TEST(DriveErrors, PathThatNoRobotDrivesInTime) {
  DriveInputs inputs = Hall();
  auto& points = inputs.path.legs_in_map[0];
  for (int i = 0; i < 1000; ++i) points.insert(points.end(), {{1, 1}, {4, 1}});
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Drive({}, inputs), "max_duration_s = 3600");
}

TEST(DriveErrors, MistakesInOptions) {
  for (const char* text : {"north", "1,2", "nan", " 5", "1e300"}) {
    NIGHTMAP_EXPECT_ERROR(UsageError, Drive(WithHeadings(text, ""), Hall()), "start_heading_deg");
    NIGHTMAP_EXPECT_ERROR(UsageError, Drive(WithHeadings("", text), Hall()), "goal_heading_deg");
  }
  DriveOptions options;
  options.controller.min_lookahead_m = 2;
  NIGHTMAP_EXPECT_ERROR(UsageError, Drive(options, Hall()), "max_lookahead_m");
}

TEST(DriveOutput, FiguresAreThoseOfTheSteps) {
  const DriveResult result = Drive({}, Hall());
  const auto json = DriveToJson(result, "a = 1\n");
  EXPECT_EQ(json.at("format"), "nightmap_drive");
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_EQ(json.at("num_steps"), result.steps.size());
  EXPECT_NEAR(json.at("duration_s"), 0.05 * static_cast<double>(result.steps.size() - 1), 1e-9);
  double length_m = 0;
  for (std::size_t i = 1; i < result.steps.size(); ++i) {
    length_m += (result.steps[i].pose.point_in_map - result.steps[i - 1].pose.point_in_map).norm();
  }
  EXPECT_NEAR(json.at("length_m"), length_m, 1e-3);
  EXPECT_NEAR(json.at("path_length_m"), 7, 1e-12);
}

TEST(DriveOutput, PicturesShowTheRobotOnItsWay) {
  DriveInputs inputs = Hall();
  FillCells(100, 100, 120, 120, kOccupiedCell, &inputs.grid);
  const DriveResult result = Drive({}, inputs);
  const std::vector<ColorImage> images = DrawDrive(inputs, result);
  ASSERT_GT(images.size(), 20U);
  ASSERT_LE(images.size(), static_cast<std::size_t>(kMaxDriveImages));
  const auto is_green = [](const ColorImage& image, const Eigen::Vector2d& point) {
    const double scale = image.width / 6.0;
    const int x = static_cast<int>(point.x() * scale);
    const int y = image.height - 1 - static_cast<int>(point.y() * scale);
    return image.At(x, y, 1) > 100 && image.At(x, y, 0) < 100;
  };
  const Eigen::Vector2d beside(0.1, 0.1);  // of the line that shows the heading
  EXPECT_TRUE(is_green(images.front(), Eigen::Vector2d(1, 1) + beside));
  EXPECT_FALSE(is_green(images.front(), Eigen::Vector2d(4, 5) + beside));
  EXPECT_TRUE(is_green(images.back(), Eigen::Vector2d(4, 5) + beside));
  EXPECT_FALSE(is_green(images.back(), Eigen::Vector2d(1, 1) + beside));
  EXPECT_EQ(images.back().At(images[0].width - 2, 2, 0), 40);  // the obstacle
  // The animation has their very pixels (gif_io_test.cc), unless they have too many colors.
  const TemporaryFolder folder;
  EXPECT_NO_THROW(WriteGif(folder / "drive.gif", images, kDriveImagesPerS));
}

}  // namespace nightmap::drive_test
