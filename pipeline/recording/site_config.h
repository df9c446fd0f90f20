// SPDX-License-Identifier: Apache-2.0
// configs/sites/<site>.toml: the recordings, cameras, other sensors and truth of one building.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

// One recording: a [[sequence]] to map, or a [[query]] of pictures to localize.
struct SequenceConfig {
  std::string layout = "tum";  // tum | seven_scenes | video | pictures
  std::string folder;          // relative to SiteConfig::root
  int camera_idx = 0;          // kOwnCameras: each picture has its own
  std::string rig;             // sequences of one rig record at once; empty: none
  // Layout pictures, only in a [[query]]: a folder of pictures, a .txt list of them, or one
  // picture, relative to root. It may lead out of the data folder.
  std::string pictures;
  double horizontal_fov_deg = 0;  // for pictures without a focal length; 0: none
  std::string video;              // layout video: the file, relative to folder
  std::string depth_folder;       // layout video: folder of depth images, relative to folder
  double frame_rate_hz = 0;       // video: 0 uses the file's rate; seven_scenes: 0 means 30
  std::string ground_truth;       // TUM trajectory relative to root, world_from_camera; empty: none
  std::string depth = "required";  // required | optional | none: whether frames have depth
  std::string label_folder;        // PNGs named like the color pictures, relative to folder
  std::string moving_folder;       // likewise: the truth of what moves
  std::string confidence_folder;   // PNGs named like the depth pictures, relative to folder
  // Layout tum: largest gap between a color image and its depth image.
  double max_association_gap_s = 0.02;
  std::string time_unit;     // of its lists and its truth: s | ms | us | ns; empty: not stated
  double time_offset_s = 0;  // added to all times of the recording
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
  std::string id;
  SignalKind kind = SignalKind::kAcceleration;
  Rigid3 robot_from_sensor;  // identity: the robot's axes are the sensor's
  // First beam of scans, where stated, step from beam to beam (0: not stated), both
  // counter-clockwise from x (scan_angles.h), and the range from which on nothing was hit.
  std::optional<double> start_angle_deg;
  double angle_step_deg = 0;
  std::optional<double> max_range_m;
  double range_unit_m = 1;  // of the ranges in the files
  double min_range_m = 0;   // nearer ones are of the robot itself
  // Sectors in which the scanner sees the robot itself: from, to, counter-clockwise from x, twice
  // as many numbers as sectors.
  std::vector<double> blind_deg;
  double scan_duration_s =
      0;  // a scan's time is that of its first beam, beam i is i/n of this later
  // Odometry: the quantity that a sample measures and, for ticks, the length of one.
  std::string measures = "pose";           // pose | motion | ticks
  double position_unit_m = 1;              // of the positions and distances in the files
  std::optional<double> heading_unit_rad;  // of the headings, where stated
  double m_per_tick = 0;
  double wheel_base_m = 0;
};

// A file of samples of one sensor: a [[signal]].
struct SignalConfig {
  int sensor_idx = 0;           // index in SiteConfig::sensors
  std::string format = "text";  // text | csv | carmen
  std::string file;             // relative to root; may be gzipped
  std::string columns;          // csv: names of its columns with time and values, comma separated
  std::string message;          // carmen: FLASER, RLASER, ROBOTLASER1, RAWLASER1 or ODOM
  std::string time_unit;        // text, csv: s | ms | us | ns; empty: not stated
  double time_offset_s = 0;     // added to all times
  bool sort = false;            // by time, for a log whose lines are out of order
  double rate_hz = 0;           // carmen: line i is at i / rate_hz; 0: lines state their times
  std::string source;           // file:line of its table, for messages
};

// A log of laser scans to locate: a [[query]] with `scans`. Each scan is a query, or with `turn`
// the whole log is one.
struct ScanQueryConfig {
  std::string scans;   // relative to root; may be gzipped, and lie outside of the data folder
  int sensor_idx = 0;  // index in SiteConfig::sensors; of kind scan
  std::string format = "carmen";   // carmen | text | csv
  std::string columns;             // csv: name of the column with the time
  std::string time_unit;           // text, csv: as in a SignalConfig
  std::string message = "FLASER";  // carmen: word that begins the lines to read
  double rate_hz = 0;              // as in a SignalConfig
  bool turn = false;               // the robot turned on the spot; the log has its odometry
  std::vector<double> near_m;      // about x, y in the map; empty: nobody knows
  double near_radius_m = 5;        // of near_m, the robot is within
  std::string source;              // file:line of its table, for messages
};

// Where the robot truly was: [robot_truth]. One of `odometry` and `trajectory`, or none with
// relations; all empty: the site has no truth of the robot.
struct RobotTruthConfig {
  std::string odometry;    // id of the [[sensor]] of kind odometry whose poses are the truth
  std::string trajectory;  // TUM, truth_from_robot; relative to root
  std::string time_unit;   // of trajectory: s | ms | us | ns; empty: not stated
  std::string relations;   // lines `time1 time2 x y z roll pitch yaw`; relative to root
  std::string source;      // file:line of its table, for messages
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
