// SPDX-License-Identifier: Apache-2.0
// Parses the tables of a site config for site_config.cc.
#pragma once

#include <toml++/toml.h>
#include <initializer_list>
#include <string>
#include <vector>

#include "pipeline/recording/site_config.h"

namespace nightmap {

// Source of the [[query]] tables that make's QUERY adds. The user sees no line numbers of them.
constexpr const char* kQuerySource = "QUERY of make";

using Names = std::vector<std::string>;

// `source:line` of the node.
std::string Where(const toml::node& node, const std::string& source);

// Throw UsageError when the table lacks one of the keys, or has one, respectively.
void Require(const toml::table& table, const Names& names, const std::string& where);
void Refuse(const toml::table& table,
            const Names& names,
            const std::string& where,
            const std::string& why);

// Throws UsageError when a path leads out of the data folder, because artifacts hold paths relative
// to it.
void CheckPath(const std::string& text, const char* key, const std::string& where);

// Parses a [[camera]] and adds it, and its mask.
void AddCamera(const toml::table& table, const std::string& source, SiteConfig* site);

// Parses a [[sensor]], and a [[signal]] of one of them.
SensorConfig ParseSensor(const toml::table& table, const std::string& source);
SignalConfig ParseSignal(const toml::table& table,
                         const std::string& source,
                         const std::vector<SensorConfig>& sensors);

// Index of the sensor. Throws UsageError naming the ones there are.
int FindSensor(const std::vector<SensorConfig>& sensors,
               const std::string& id,
               const std::string& where);

// Parses a [[query]] with `scans`, which no other one of the site may name. Where it says nothing
// of its format, that is the format of the sensor's first [[signal]], else FLASER lines of CARMEN.
ScanQueryConfig ParseScanQuery(const toml::table& table,
                               const std::string& source,
                               const SiteConfig& site);

// Parses [robot_truth], which may name one of the sensors.
RobotTruthConfig ParseRobotTruth(const toml::table& table,
                                 const std::string& source,
                                 const std::vector<SensorConfig>& sensors);

// Pose from the key's seven numbers tx ty tz qx qy qz qw. Throws UsageError when they are not a
// pose.
Rigid3 ToPose(const std::vector<double>& values, const char* key, const std::string& where);

}  // namespace nightmap
