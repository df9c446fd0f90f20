// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/site_config.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::site_config_test {

constexpr const char* kSite = R"(root = "office"
hold_out_every = 5
[[camera]]
id = "color"
width = 640
height = 480
fx = 517.3
fy = 516.5
cx = 318
cy = 255.3
k1 = 0.25
depth_units_per_m = 5000
[[sequence]]
layout = "tum"
folder = "one"
camera = "color"
ground_truth = "truth.txt"
[[sequence]]
layout = "video"
folder = "two"
camera = "color"
video = "clip.avi"
depth_folder = "depth"
time_offset_s = 100.5
[[query]]
layout = "seven_scenes"
folder = "q"
camera = "color"
frame_rate_hz = 15
)";

std::string Replaced(const std::string& from, const std::string& to) {
  std::string text = kSite;
  EXPECT_NE(text.find(from), std::string::npos) << from;
  return text.replace(text.find(from), from.size(), to);
}

TEST(SiteConfig, EveryTableIsRead) {
  const SiteConfig site = ParseSiteConfig(kSite, "site.toml");
  EXPECT_EQ(site.root, "office");
  EXPECT_EQ(site.hold_out_every, 5);
  ASSERT_EQ(site.cameras.size(), 1u);
  EXPECT_EQ(site.cameras[0].camera_id, "color");
  EXPECT_EQ(site.cameras[0].color.cx, 318);
  EXPECT_EQ(site.cameras[0].color.k1, 0.25);
  EXPECT_TRUE(site.cameras[0].depth_registered);
  EXPECT_EQ(site.cameras[0].depth_units_per_m, 5000);
  ASSERT_EQ(site.sequences.size(), 2u);
  EXPECT_EQ(site.sequences[0].ground_truth, "truth.txt");
  EXPECT_EQ(site.sequences[1].video, "clip.avi");
  EXPECT_EQ(site.sequences[1].time_offset_s, 100.5);
  ASSERT_EQ(site.queries.size(), 1u);
  EXPECT_EQ(site.queries[0].frame_rate_hz, 15);
  EXPECT_EQ(site.queries[0].source, "site.toml:25");
}

TEST(SiteConfig, DepthWithoutUnitsIsInMetres) {
  const auto site = ParseSiteConfig(Replaced("depth_units_per_m = 5000\n", ""), "s.toml");
  EXPECT_EQ(site.cameras[0].depth_units_per_m, 0);
}

TEST(SiteConfig, LargePicturesAreSeenSmaller) {
  const auto color = [](const std::string& key) {
    const RgbdCamera camera =
        ParseSiteConfig(Replaced("k1 = 0.25", "k1 = 0.25" + key), "site.toml").cameras[0];
    EXPECT_EQ(camera.Picture().width, 640);
    EXPECT_EQ(camera.Picture().height, 480);
    return camera.color;
  };
  EXPECT_EQ(color("").width, 640);
  EXPECT_EQ(color("\nworking_mpx = 0.3072").width, 640);
  const Camera reduced = color("\nworking_mpx = 0.0768");
  EXPECT_EQ(reduced.width, 320);
  EXPECT_EQ(reduced.height, 240);
  EXPECT_DOUBLE_EQ(reduced.cx, (318 + 0.5) / 2 - 0.5);
  EXPECT_EQ(reduced.k1, 0.25);
}

TEST(SiteConfig, ConfidenceNeedsItsFolderAndItsLeastValue) {
  std::string text = Replaced("k1 = 0.25", "min_confidence = 2");
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      ParseSiteConfig(text, "s.toml"),
      "s.toml:13: 'confidence_folder' is missing, which goes with min_confidence");
  for (std::size_t at = text.find("[[sequence]]\n"); at != std::string::npos;
       at = text.find("[[sequence]]\n", at + 1)) {
    text.insert(at + 13, "confidence_folder = \"sure\"\n");
  }
  const auto site = ParseSiteConfig(text, "s.toml");
  EXPECT_EQ(site.cameras[0].min_confidence, 2);
  EXPECT_EQ(site.sequences[1].confidence_folder, "sure");
  text.erase(text.find("min_confidence = 2"), 18);
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseSiteConfig(text, "s.toml"),
                        "'confidence_folder' needs min_confidence of the [[camera]] \"color\"");
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      ParseSiteConfig(Replaced("[[query]]\n", "[[query]]\nconfidence_folder = \"c\"\n"), "s.toml"),
      "'confidence_folder' is for a [[sequence]]: remove it");
}

TEST(SiteConfig, UnregisteredDepthNeedsItsCamera) {
  const std::string keys =
      "depth_registered = false\ndepth_width = 320\ndepth_height = 240\ndepth_fx = 250\n"
      "depth_fy = 250\ndepth_cx = 160\ndepth_cy = 120\n";
  const auto with = [&](const std::string& extra) {
    return ParseSiteConfig(Replaced("k1 = 0.25\n", keys + extra), "s.toml");
  };
  const auto site = with("color_from_depth = [0.025, 0, 0, 0, 0, 0, 1]\n");
  EXPECT_FALSE(site.cameras[0].depth_registered);
  EXPECT_EQ(site.cameras[0].depth.width, 320);
  EXPECT_EQ(site.cameras[0].color_from_depth.translation.x(), 0.025);
  NIGHTMAP_EXPECT_ERROR(UsageError, with(""), "'color_from_depth' is missing");
  NIGHTMAP_EXPECT_ERROR(UsageError, with("color_from_depth = [1, 2]\n"), "2 numbers");
  NIGHTMAP_EXPECT_ERROR(
      UsageError, with("color_from_depth = [0, 0, 0, 0, 0, 0, 2]\n"), "give a unit one");
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseSiteConfig(Replaced("k1 = 0.25", "depth_fx = 250"), "s.toml"),
                        "'depth_fx' needs depth_registered = false");
}

TEST(SiteConfig, PlainPicturesAreQueriesWithACameraOrTheirOwn) {
  const auto with = [](const std::string& keys) {
    return ParseSiteConfig(kSite + std::string("[[query]]\nlayout = \"pictures\"\n") + keys,
                           "s.toml");
  };
  const auto own = with("pictures = \"../photos\"\nhorizontal_fov_deg = 65\n").queries.at(1);
  EXPECT_EQ(own.pictures, "../photos");
  EXPECT_EQ(own.camera_idx, kOwnCameras);
  EXPECT_EQ(own.horizontal_fov_deg, 65);
  const auto given = with("pictures = \"a.jpg\"\ncamera = \"color\"\nground_truth = \"t\"\n");
  EXPECT_EQ(given.queries.at(1).camera_idx, 0);
  const auto expect = [&](const std::string& keys, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(UsageError, with(keys), why);
  };
  expect("", "s.toml:30: 'pictures' is missing");
  expect("pictures = \"/photos\"\n", "s.toml:30: pictures = \"/photos\" must be relative");
  expect("pictures = \"a\"\nfov_deg = 60\n", "s.toml:33: unknown key 'fov_deg'");
  expect("pictures = \"a\"\nhorizontal_fov_deg = 0\n", "s.toml:33: horizontal_fov_deg = 0");
  expect("pictures = \"a\"\nhorizontal_fov_deg = nan\n", "s.toml:33: horizontal_fov_deg = nan");
  expect("pictures = \"a\"\nhorizontal_fov_deg = 60\ncamera = \"color\"\n", "known from `camera`");
  expect("pictures = \"a\"\nfolder = \"b\"\n", "'folder' does not go with layout = \"pictures\"");
  expect("pictures = \"a\"\ntime_offset_s = 1\n", "'time_offset_s' does not go with");
  expect("pictures = \"a\"\nvideo = \"b\"\n", "'video' needs layout = \"video\"");
  expect("pictures = \"a\"\ncamera = \"gray\"\n", "no [[camera]] has id \"gray\"");
}

TEST(SiteConfig, MistakesAreNamedWithTheirLine) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(UsageError, ParseSiteConfig(Replaced(from, to), "s.toml"), why);
    try {
      ParseSiteConfig(Replaced(from, to), "s.toml");
    } catch (const UsageError& error) {
      EXPECT_EQ(error.Code(), ExitCode::kUsageError);
      EXPECT_THAT(error.what(), testing::StartsWith("s.toml"));
    }
  };
  expect("cx = 318", "cx = 3186", "cx = 3186 is far outside the picture, whose width is 640");
  expect("k1 = 0.25", "k7 = 0.25", "s.toml:11: unknown key 'k7'");
  expect("root =", "rot =", "s.toml:1: unknown key 'rot'");
  expect("[[query]]", "[[queries]]", "s.toml:25: unknown key 'queries'");
  expect("[[camera]]", "[camera]", "must be written as [[camera]]");
  expect("width = 640", "width = \"wide\"", "s.toml:5: 'width' must be an integer");
  expect("width = 640", "width = 640.5", "s.toml:5: 'width' must be an integer");
  expect("width = 640", "width = 0", "s.toml:5: width = 0 is out of range");
  expect("fx = 517.3", "fx = -1", "s.toml:7: fx = -1.0 is out of range");
  expect("fx = 517.3", "fx = nan", "s.toml:7: fx = nan");
  expect("k1 = 0.25",
         "depth_noise_constant_m = 0.0",
         "s.toml:11: depth_noise_constant_m = 0.0 is out of range; give 1e-05 .. 1");
  expect("k1 = 0.25", "k1 = 0.25\nk2 = -0.95\np1 = 1.16", "s.toml:3: k1 k2 p1 p2 k3");
  const std::string four = "k1 = 0.25\nk2 = 0\nk3 = 0\nk4 = 0", fisheye = "lens = \"fisheye\"\n";
  expect("k1 = 0.25", four, "s.toml:3: k4 k5 k6 belong to OpenCV's eight");
  expect("k1 = 0.25", "lens = \"fish\"", "s.toml:11: lens = \"fish\" is out of range");
  expect("k1 = 0.25", fisheye + "k1 = 0.25", "s.toml:3: 'k2' is missing");
  expect("k1 = 0.25", fisheye + four + "\np1 = 0", "'p1' is not of lens = \"fisheye\"");
  expect("k1 = 0.25", fisheye + "k1 = 0.25\nk2 = -1.95\nk3 = 0\nk4 = 0", "of the fisheye fold");
  expect("k1 = 0.25", fisheye + "k1 = nan\nk2 = 0\nk3 = 0\nk4 = 0", "k1 = nan");
  expect("fx = 517.3\n", "", "s.toml:3: 'fx' is missing");
  expect("k1 = 0.25", "min_depth_m = 20.0", "must be below max_depth_m");
  expect("layout = \"tum\"", "layout = \"tumm\"", "s.toml:14: layout = \"tumm\" is out of range");
  expect("folder = \"one\"\n", "", "s.toml:13: 'folder' is missing");
  expect("folder = \"one\"", "folder = \"/one\"", "must lie inside the data folder");
  expect("folder = \"one\"", "folder = \"a/../../b\"", "must lie inside the data folder");
  expect("root = \"office\"", "root = \"/office\"", "must lie inside the data folder");
  expect(
      "camera = \"color\"", "camera = \"gray\"", "no [[camera]] has id \"gray\"; there are: color");
  expect("k1 = 0.25", "mask = \"../m.png\"", "mask = \"../m.png\" must lie inside the data folder");
  expect("k1 = 0.25", "picture_bits = 8", "s.toml:11: picture_bits = 8 is out of range; give 9");
  expect("k1 = 0.25", "mask = 1", "s.toml:11: 'mask' must be a string");
  expect("video = \"clip.avi\"\n", "", "'video' is missing");
  expect("frame_rate_hz = 15", "video = \"a.avi\"", "'video' needs layout = \"video\"");
  expect("frame_rate_hz = 15", "pictures = \"a\"", "'pictures' needs layout = \"pictures\"");
  expect("camera = \"color\"\n", "", "s.toml:13: 'camera' is missing");
  expect("layout = \"tum\"\nfolder = \"one\"",
         "layout = \"pictures\"\npictures = \"one\"",
         "s.toml:13: layout = \"pictures\" has no depth to map: make it a [[query]]");
  expect("frame_rate_hz = 15", "frame_rate_hz = 1e-300", "frame_rate_hz = 1e-300 is out of range");
  expect("hold_out_every = 5", "hold_out_every = 1", "would leave nothing to map");
  expect("hold_out_every = 5", "hold_out_every = -1", "s.toml:2: hold_out_every = -1");
  expect("hold_out_every = 5", "hold_out_every = ", "s.toml:2: not valid TOML");
}

TEST(SiteConfig, SequencesMayBeOfARig) {
  const auto site = ParseSiteConfig(
      Replaced("folder = \"one\"\n", "folder = \"one\"\nrig = \"head\"\n"), "s.toml");
  EXPECT_EQ(site.sequences[0].rig, "head");
  EXPECT_EQ(site.sequences[1].rig, "");
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      ParseSiteConfig(Replaced("[[query]]\n", "[[query]]\nrig = \"head\"\n"), "s.toml"),
      "s.toml:25: 'rig' is for a [[sequence]]: remove it");
}

TEST(SiteConfig, LinksMayBeAllowedToLeadOutside) {
  const auto with = [](const std::string& keys) {
    return ParseSiteConfig(Replaced("folder = \"one\"\n", "folder = \"one\"\n" + keys), "s.toml");
  };
  const auto site = with("allow_outside = [\"rgb\", \"a/b.png\"]\n");
  EXPECT_EQ(site.sequences[0].allow_outside, (std::vector<std::string>{"rgb", "a/b.png"}));
  EXPECT_TRUE(site.sequences[1].allow_outside.empty());
  const auto expect = [&](const std::string& keys, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(UsageError, with(keys), why);
  };
  expect("allow_outside = \"rgb\"\n", "s.toml:16: 'allow_outside' must be a list of paths");
  expect("allow_outside = [1]\n", "s.toml:16: 'allow_outside' must be a list of paths");
  expect("allow_outside = [\"\"]\n", "s.toml:16: 'allow_outside' must be a list of paths");
  expect("allow_outside = [\"/mnt\"]\n", "s.toml:16: allow_outside = \"/mnt\" must lie inside");
  const std::string query =
      "[[query]]\nlayout = \"pictures\"\npictures = \"a\"\nallow_outside = [\"a\"]\n";
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseSiteConfig(kSite + query, "s.toml"),
                        "s.toml:30: 'allow_outside' is for recordings");
}

TEST(SiteConfig, ACopyNamesTheFileToEdit) {
  const std::string end = "\n# This was the text of configs/sites/s.toml\n";
  const auto site = ParseSiteConfig(kSite + end, "maps/s/config/site/s.toml");
  ASSERT_EQ(site.queries.size(), 1u);
  EXPECT_EQ(site.queries[0].source, "configs/sites/s.toml:25");
  const auto expect = [&](const std::string& text, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(UsageError, ParseSiteConfig(text, "maps/s/config/site/s.toml"), why);
  };
  expect(Replaced("fx = 517.3", "fx = -1") + end, "configs/sites/s.toml:7: fx = -1.0");
  expect(Replaced("fx = 517.3", "fx = ") + end, "configs/sites/s.toml:7: not valid TOML");
  // Only the last line of the file is make's.
  const auto own = ParseSiteConfig(kSite + end + "# a comment\n", "own.toml");
  EXPECT_EQ(own.queries[0].source, "own.toml:25");
}

TEST(SiteConfig, AskedQueriesComeAfterThoseOfTheSite) {
  const std::string query = "[[query]]\nlayout = \"pictures\"\npictures = \"../a.jpg\"\n";
  SiteConfig site = ParseSiteConfig(kSite, "s.toml");
  ParseAskedQueries("", &site);
  EXPECT_EQ(site.queries.size(), 1u);
  ParseAskedQueries(query + query + "camera = \"" + site.cameras[0].camera_id + "\"\n", &site);
  ASSERT_EQ(site.queries.size(), 3u);
  EXPECT_EQ(site.queries[0].source, "s.toml:25");
  EXPECT_EQ(site.queries[1].source, "QUERY of make");
  EXPECT_EQ(site.queries[1].camera_idx, kOwnCameras);
  EXPECT_EQ(site.queries[2].pictures, "../a.jpg");
  EXPECT_EQ(site.queries[2].camera_idx, 0);
  const auto expect = [&](const std::string& text, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(UsageError, ParseAskedQueries(text, &site), why);
  };
  expect(query + "camera = \"x\"\n", "QUERY of make: no [[camera]] has id \"x\"");
  expect(query + "horizontal_fov_deg = 0\n", "horizontal_fov_deg = 0.0 is out of range");
  expect("root = \"a\"\n", "QUERY of make");
  expect("[query]\n", "QUERY of make: 'query' must be written as [[query]]");
}

constexpr const char* kLaserSite = R"(root = "lab"
[[sensor]]
id = "laser"
kind = "scan"
max_range_m = 30
scan_duration_s = 0.075
robot_from_sensor = [0.1, 0, 0.2, 0, 0, 0, 1]
[[sensor]]
id = "wheels"
kind = "odometry"
measures = "ticks"
m_per_tick = 0.001
wheel_base_m = 0.4
[[signal]]
sensor = "laser"
format = "carmen"
file = "a.log.gz"
message = "FLASER"
[[signal]]
sensor = "wheels"
format = "csv"
file = "b.csv"
columns = "t,l,r"
time_offset_s = 2
)";

TEST(SiteConfig, ASiteMayHaveSignalsWithoutFrames) {
  const auto site = ParseSiteConfig(kLaserSite, "s.toml");
  EXPECT_TRUE(site.cameras.empty() && site.sequences.empty());
  ASSERT_EQ(site.sensors.size(), 2u);
  EXPECT_EQ(site.sensors[0].kind, SignalKind::kScan);
  EXPECT_EQ(site.sensors[0].max_range_m, 30);
  EXPECT_EQ(site.sensors[0].scan_duration_s, 0.075);
  EXPECT_EQ(site.sensors[0].robot_from_sensor.translation, Eigen::Vector3d(0.1, 0, 0.2));
  EXPECT_EQ(site.sensors[1].measures, "ticks");
  ASSERT_EQ(site.signals.size(), 2u);
  EXPECT_EQ(site.signals[1].sensor_idx, 1);
  EXPECT_EQ(site.signals[1].columns, "t,l,r");
  EXPECT_EQ(site.signals[1].source, "s.toml:19");
  const auto both = ParseSiteConfig(std::string(kSite) +
                                        "[[sensor]]\nid = \"imu\"\nkind = "
                                        "\"acceleration\"\n",
                                    "s.toml");
  EXPECT_EQ(both.sensors.size(), 1u);
}

TEST(SiteConfig, MistakesInSignalsAreNamedWithTheirLine) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& why) {
    std::string text = kLaserSite;
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    NIGHTMAP_EXPECT_ERROR(UsageError, ParseSiteConfig(text, "s.toml"), why);
  };
  expect("kind = \"scan\"\n", "", "s.toml:2: 'kind' is missing");
  expect("kind = \"scan\"", "kind = \"sonar\"", "s.toml:4: kind");
  expect("id = \"wheels\"", "id = \"laser\"", "s.toml:8: a second sensor \"laser\": rename it");
  expect("measures = \"ticks\"\n", "", "s.toml:8: 'm_per_tick' needs measures = \"ticks\"");
  expect("wheel_base_m = 0.4\n", "", "s.toml:8: ticks need m_per_tick and wheel_base_m");
  expect("measures", "max_range_m = 3\nmeasures", "'max_range_m' is of a scan");
  expect("max_range_m", "start_angle_deg = 90\nmax_range_m", "add angle_step_deg (negative: clock");
  expect("measures", "position_unit = \"mm\"\nmeasures", "'position_unit' does not go with ticks");
  expect("max_range_m", "heading_unit = \"deg\"\nmax_range_m", "'heading_unit' is of odometry");
  expect("measures", "range_unit = \"mm\"\nmeasures", "'range_unit' is of a scan");
  expect("max_range_m", "range_unit = \"inch\"\nmax_range_m", "range_unit");
  expect("sensor = \"wheels\"\n", "sensor = \"laser\"\n", "must name the time alone: of a scan");
  expect("measures", "min_range_m = 0\nmeasures", "'min_range_m' is of a scan");
  expect("measures", "blind_deg = []\nmeasures", "'blind_deg' is of a scan");
  expect("max_range_m",
         "blind_deg = [1, 2, 3]\nmax_range_m",
         "s.toml:2: blind_deg = [1, 2, 3] must have from and to");
  expect("max_range_m", "blind_deg = [1, 2, -180, 180]\nmax_range_m", "no sector is empty");
  expect("measures", "scan_duration_s = 0\nmeasures", "'scan_duration_s' is of a scan");
  expect("0.075", "-0.1", "s.toml:6: scan_duration_s");
  expect("0.2, 0, 0, 0, 1]", "0.2, 0, 0, 0]", "robot_from_sensor has 6 numbers");
  expect("0.2, 0, 0, 0, 1]", "0.2, 0, 0, 0, 2]", "quaternion in robot_from_sensor has length 2");
  expect("sensor = \"laser\"",
         "sensor = \"sonar\"",
         "no [[sensor]] has id \"sonar\"; there are: laser");
  expect("message = \"FLASER\"\n", "", "s.toml:14: 'message' is missing");
  expect("FLASER", "ODOM", "message = \"ODOM\" holds no scan");
  expect("columns = \"t,l,r\"\n", "", "s.toml:19: 'columns' is missing");
  expect("\"carmen\"", "\"text\"", "'message' needs format = \"carmen\"");
  expect("time_offset_s", "rate_hz", "s.toml:19: 'rate_hz' needs format = \"carmen\"");
  expect("message = \"FLASER\"",
         "message = \"FLASER\"\ntime_unit = \"ms\"",
         "'time_unit' does not go with format = \"carmen\": it has seconds");
  expect("columns = \"t,",
         "time_unit = \"ns\"\ncolumns = \"t_ns,",
         "'time_unit' is stated by the name");
  expect("columns", "time_unit = \"min\"\ncolumns", "time_unit");
  expect("\"a.log.gz\"", "\"../a.log\"", "file = \"../a.log\" must lie inside the data folder");
  expect("time_offset_s", "time_ofset_s", "s.toml:24: unknown key 'time_ofset_s'");
}

TEST(SiteConfig, TheTruthOfTheRobotIsOfASensorOrAFile) {
  const auto read = [](const std::string& table, const std::string& kind = "ticks") {
    std::string text = kLaserSite;
    text.replace(text.find("ticks"), 5, kind);
    return ParseSiteConfig(text + "[robot_truth]\n" + table, "s.toml").robot_truth;
  };
  EXPECT_EQ(read("odometry = \"wheels\"\nrelations = \"a.relations\"").odometry, "wheels");
  EXPECT_EQ(read("trajectory = \"a.tum\"").trajectory, "a.tum");
  EXPECT_EQ(read("relations = \"a.relations\"").relations, "a.relations");
  EXPECT_EQ(read("relations = \"a.relations\"").source, "s.toml:25");
  EXPECT_TRUE(ParseSiteConfig(kLaserSite, "s.toml").robot_truth.source.empty());
  const auto expect = [&](const std::string& table, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(UsageError, read(table), why);
  };
  expect("", "s.toml:25: no truth: add `odometry`, `trajectory` or `relations`");
  expect("odometry = \"wheels\"\ntrajectory = \"a.tum\"",
         "s.toml:25: the robot has one truth: remove");
  expect("odometry = \"wheel\"",
         "s.toml:25: no [[sensor]] has id \"wheel\"; there are: laser, wheels");
  expect("odometry = \"laser\"",
         "s.toml:25: odometry = \"laser\" is a sensor of kind scan: name one");
  expect("odometry = 3", "s.toml:26: 'odometry' must be");
  expect("relations = \"a\"\ntime_unit = \"ms\"", "'time_unit' is of `trajectory`");
  expect("relation = \"a\"", "s.toml:26: unknown key 'relation'");
  expect("trajectory = \"/a\"", "trajectory = \"/a\" must lie inside the data folder");
  expect("relations = \"../a\"", "relations = \"../a\" must lie inside the data folder");
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseSiteConfig("robot_truth = 1\n" + std::string(kLaserSite), "s.toml"),
                        "s.toml:1: 'robot_truth' must be written as [robot_truth]");
}

TEST(SiteConfig, CamerasAndSequencesMustBeThere) {
  const std::string site = kSite;
  const auto camera = site.find("[[camera]]"), sequence = site.find("[[sequence]]");
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseSiteConfig(site.substr(0, camera) +
                                            "[[query]]\nlayout = \"pictures\"\npictures = \"a\"\n" +
                                            std::string(kLaserSite).substr(13),
                                        "s.toml"),
                        "add a [[camera]]");
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseSiteConfig(site.substr(0, sequence), "s.toml"),
                        "add a [[sequence]] of frames or a [[signal]]");
  const std::string alone = site.substr(0, sequence) + "[import]\n";
  EXPECT_TRUE(ParseSiteConfig(alone + "map = \"a.yaml\"\n", "s.toml").sequences.empty());
  EXPECT_THROW(ParseSiteConfig(alone + "trajectory = \"a.tum\"\n", "s.toml"), UsageError);
  const std::string table = site.substr(camera, sequence - camera);
  NIGHTMAP_EXPECT_ERROR(
      UsageError, ParseSiteConfig(site + table, "s.toml"), "s.toml:30: a second camera \"color\"");
}

bool SeesAll(const Camera& camera) {
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (!camera.Sees(Eigen::Vector2d(x, y))) return false;
    }
  }
  return true;
}

// Only git tells them from configs that a user put into the folder, whose mistakes are no failure
// of the project.
TEST(SiteConfig, TheSitesOfTheProjectAreValid) {
  if (!std::filesystem::exists(".git")) GTEST_SKIP() << "not a checkout of git";
  const TemporaryFolder folder;
  const std::string list = "git ls-files 'configs/sites/*.toml' | grep -v '/.*/.*/' > ";
  ASSERT_EQ(std::system((list + (folder / "sites").string()).c_str()), 0);
  std::ifstream lines(folder / "sites");
  const std::vector<std::string> sites{std::istream_iterator<std::string>(lines), {}};
  EXPECT_GT(sites.size(), 10U);
  for (const std::string& site : sites) {
    SiteConfig config;
    EXPECT_NO_THROW(config = ReadSiteConfig(site)) << site;
    for (const RgbdCamera& camera : config.cameras) {
      EXPECT_TRUE(SeesAll(camera.color)) << site;  // so nothing is masked
    }
  }
}

}  // namespace nightmap::site_config_test
