// SPDX-License-Identifier: Apache-2.0
// Tables of a site config, for site_config.cc.
#pragma once

#include <toml++/toml.h>
#include <initializer_list>
#include <string>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// Source of the [[query]] tables that QUERY of make adds. Whoever runs make sees no lines of them.
constexpr const char* kQuerySource = "QUERY of make";

using Names = std::initializer_list<const char*>;

// `source:line` of the node.
std::string Where(const toml::node& node, const std::string& source);

// Throw UsageError when the table lacks one of the keys, or has one.
void Require(const toml::table& table, Names names, const std::string& where);
void Refuse(const toml::table& table, Names names, const std::string& where, const char* why);

// A [[camera]].
RgbdCamera ParseCamera(const toml::table& table, const std::string& source);

}  // namespace nightmap
