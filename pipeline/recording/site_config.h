// SPDX-License-Identifier: Apache-2.0
// configs/sites/<site>.toml: the recordings, cameras, other sensors and truth of one building.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

// Values of `time_unit`. Empty: seconds, unless they cannot be.
inline const std::vector<std::string> kTimeUnits = {"", "s", "ms", "us", "ns"};

std::vector<std::string> NamesOfLayouts();  // those of layouts.h

// One recording: a [[sequence]] to map, or a [[query]] of pictures to localize.
struct SequenceConfig {
  OPTION(std::string, layout, "tum", NamesOfLayouts(), "folder layout of the recording");
  OPTION(std::string, folder, "", "relative to root");
  int camera_idx = 0;  // kOwnCameras: each picture has its own
  OPTION(std::string, rig, "", "sequences of one rig record at once; empty: none");
  OPTION(std::string, pictures, "",
         "layout pictures, of a [[query]]: folder of pictures, .txt list of them, or one picture, "
         "relative to root; may lead out of the data folder");
  OPTION(double, horizontal_fov_deg, 0, {1, 170},
         "layout pictures: for pictures without a focal length");
  OPTION(std::string, video, "", "layout video: the file, relative to folder");
  OPTION(std::string, depth_folder, "", "layout video: depth images, relative to folder");
  OPTION(double, frame_rate_hz, 0, {0, 1000}, "0: the video's, 30 for seven_scenes");
  OPTION(std::string, ground_truth, "", "TUM trajectory, world_from_camera, relative to root");
  OPTION(std::string, depth, "required", {"required", "optional", "none"},
         "whether frames have depth");
  OPTION(std::string, label_folder, "", "label PNGs named like the color pictures");
  OPTION(std::string, moving_folder, "", "likewise, with the truth of what moves: not 0");
  OPTION(std::string, confidence_folder, "", "PNGs named like the depth pictures");
  OPTION(double, max_association_gap_s, 0.02, {0, 10}, "color to depth image");
  OPTION(std::string, time_unit, "", kTimeUnits, "of its lists and ground_truth; empty: s");
  OPTION(double, time_offset_s, 0, {-2e9, 2e9}, "added to all times of the recording");
  REGISTER_OPTIONS();
  // Links in the recording (relative to folder) that may, with everything below them, lead out of
  // it and of the data folder.
  std::vector<std::string> allow_outside;
  std::string source;  // file:line of its table, for messages
};

constexpr int kOwnCameras = -1;
constexpr double kMinFrameRate_hz = 0.001;  // of a video

// A sensor other than a camera: a [[sensor]]. Sensor axes of a laser and of wheels: x forward, y
// left, z up. The poses of its sensors define the robot's axes.
struct SensorConfig {
  OPTION(std::string, id, "", "name that signals refer to");
  SignalKind kind = SignalKind::kAcceleration;
  Rigid3 robot_from_sensor;  // identity: the robot's axes are the sensor's
  // First beam of scans, where stated, counter-clockwise from x (scan_angles.h).
  std::optional<double> start_angle_deg;
  OPTION(double, angle_step_deg, 0, {-90, 90},
         "scan: from beam to beam, counter-clockwise; 0: beams share the field of view");
  std::optional<double> max_range_m;  // from which on nothing was hit
  double range_unit_m = 1;            // of the ranges in the files
  OPTION(double, min_range_m, 0, {0, 100}, "scan: nearer is the robot itself");
  OPTION(std::vector<double>, blind_deg, {}, {-360, 360},
         "scan: sectors in which it sees the robot itself: from, to, counter-clockwise from x");
  OPTION(double, scan_duration_s, 0, {0, kMaxScanDuration_s},
         "scan: from its first beam, whose time it states, to its end; 0: at once");
  OPTION(std::string, measures, "pose", {"pose", "motion", "ticks"},
         "odometry: quantity that a sample measures");
  double position_unit_m = 1;              // of the positions and distances in the files
  std::optional<double> heading_unit_rad;  // of the headings, where stated
  OPTION(double, m_per_tick, 0, {0, 100}, "odometry of ticks: distance per tick, m");
  OPTION(double, wheel_base_m, 0, {0, 100}, "odometry of ticks: distance between the wheels");
  REGISTER_OPTIONS();
};

// A file of samples of one sensor: a [[signal]].
struct SignalConfig {
  int sensor_idx = 0;  // index in SiteConfig::sensors
  OPTION(std::string, format, "text", {"text", "csv", "carmen"}, "format of the file");
  OPTION(std::string, file, "", "relative to root; may be gzipped");
  OPTION(std::string, columns, "", "csv: names of columns with time and values, comma separated");
  OPTION(std::string, message, "", {"", "FLASER", "RLASER", "ROBOTLASER1", "RAWLASER1", "ODOM"},
         "carmen: word that begins the lines to read");
  OPTION(std::string, time_unit, "", kTimeUnits, "text, csv: of its times; empty: s");
  OPTION(double, time_offset_s, 0, {-2e9, 2e9}, "added to all times");
  OPTION(bool, sort, false, "sorts the samples by time, for a log whose lines are out of order");
  OPTION(double, rate_hz, 0, {0, 1e4}, "carmen: line i is at i / rate_hz; 0: lines have times");
  REGISTER_OPTIONS();
  std::string source;  // file:line of its table, for messages
};

// A log of laser scans to locate: a [[query]] with `scans`. Each scan is a query, or with `turn`
// the whole log is one.
struct ScanQueryConfig {
  OPTION(std::string, scans, "",
         "log of scans, relative to root; may be gzipped, and lie outside of the data folder");
  int sensor_idx = 0;  // index in SiteConfig::sensors; of kind scan
  OPTION(std::string, format, "carmen", {"text", "csv", "carmen"}, "format of the log");
  OPTION(std::string, columns, "", "csv: name of the column with the time");
  std::string time_unit;  // text, csv: as in a SignalConfig
  OPTION(std::string, message, "FLASER", {"FLASER", "RLASER", "ROBOTLASER1", "RAWLASER1"},
         "carmen: word that begins the lines to read");
  double rate_hz = 0;  // as in a SignalConfig
  OPTION(bool, turn, false, "the scans are one query, of a robot that turned on the spot");
  OPTION(std::vector<double>, near_m, {}, {-1e6, 1e6}, "about x, y in the map; empty: unknown");
  OPTION(double, near_radius_m, 5, {0, 1e6}, "the robot is within this distance of near_m");
  REGISTER_OPTIONS();
  std::string source;  // file:line of its table, for messages
};

// Where the robot truly was: [robot_truth]. One of `odometry` and `trajectory`, or none with
// relations; all empty: the site has no truth of the robot.
struct RobotTruthConfig {
  OPTION(std::string, odometry, "", "id of the [[sensor]] of kind odometry that is the truth");
  OPTION(std::string, trajectory, "", "TUM file of truth_from_robot, relative to root");
  OPTION(std::string, time_unit, "", kTimeUnits, "of the trajectory; empty: s");
  OPTION(std::string, relations, "",
         "lines `time1 time2 x y z roll pitch yaw`, relative to root");
  REGISTER_OPTIONS();
  std::string source;  // file:line of its table, for messages
};

// Picture of the parts of the robot that a camera sees: `mask` of a [[camera]].
struct CameraMaskConfig {
  int camera_idx = 0;
  std::string file;    // relative to root
  std::string source;  // file:line of the camera's table, for messages
};

struct SiteConfig {
  std::string root = ".";               // relative to the data folder
  int hold_out_every = 0;               // every Nth frame becomes a query; 0: none
  std::vector<RgbdCamera> cameras;      // without masks, until ReadCameraMasks
  std::vector<CameraMaskConfig> masks;  // those that cameras have
  std::vector<SequenceConfig> sequences;
  std::vector<SequenceConfig> queries;        // of pictures
  std::vector<ScanQueryConfig> scan_queries;  // of laser scans
  std::vector<SensorConfig> sensors;
  std::vector<SignalConfig> signals;
  RobotTruthConfig robot_truth;
};

// Strict: an unknown or missing key, a wrong type, a value out of range, an absolute path, an
// unknown camera, a key that does not fit its layout, or neither a recording nor a map to import is
// a UsageError naming `source`, line and remedy. Make passes programs a copy of the user's config:
// the user's text line for line, then a comment `# This was the text of FILE`. Messages name FILE,
// which the user can edit.
SiteConfig ParseSiteConfig(std::string_view text, const std::string& source);
SiteConfig ReadSiteConfig(const std::filesystem::path& path);
// Throws what ReadSiteConfig throws.
void CheckSiteConfig(const std::filesystem::path& path);

// Appends the [[query]] tables that QUERY of make asks for; they may name cameras and scanners of
// the site. The text holds nothing else, and is empty without QUERY. Mistakes are a UsageError
// naming QUERY.
void ParseAskedQueries(std::string_view text, SiteConfig* site);
void ReadAskedQueries(const std::filesystem::path& path, SiteConfig* site);
// Throws what ReadAskedQueries, or ReadSiteConfig before it, throws.
void CheckAskedQueries(const std::filesystem::path& path, const std::filesystem::path& site_path);

}  // namespace nightmap
