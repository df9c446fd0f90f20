// SPDX-License-Identifier: Apache-2.0
// Tables of a site config, for site_config.cc.
#pragma once

#include <toml++/toml.h>
#include <initializer_list>
#include <string>
#include <vector>

#include "pipeline/io/site_config.h"

namespace nightmap {

// Source of the [[query]] tables that QUERY of make adds. Whoever runs make sees no lines of them.
constexpr const char* kQuerySource = "QUERY of make";

using Names = std::initializer_list<const char*>;

// `source:line` of the node.
std::string Where(const toml::node& node, const std::string& source);

// Throw UsageError when the table lacks one of the keys, or has one.
void Require(const toml::table& table, Names names, const std::string& where);
void Refuse(const toml::table& table, Names names, const std::string& where, const char* why);

// Artifacts hold paths relative to the data folder: throws UsageError when a path leads out of it.
void CheckPath(const std::string& text, const char* key, const std::string& where);

// A [[camera]].
RgbdCamera ParseCamera(const toml::table& table, const std::string& source);

// A [[sensor]], and a [[signal]] of one of them.
SensorConfig ParseSensor(const toml::table& table, const std::string& source);
SignalConfig ParseSignal(const toml::table& table,
                         const std::string& source,
                         const std::vector<SensorConfig>& sensors);

// Seven numbers tx ty tz qx qy qz qw of the key. Throws UsageError when they are no pose.
Rigid3 ToPose(const std::vector<double>& values, const char* key, const std::string& where);

}  // namespace nightmap
