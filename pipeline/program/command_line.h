// SPDX-License-Identifier: Apache-2.0
// The command line that all stages have.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/program/stage_context.h"

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11's name
class App;
}

namespace nightmap {

struct CommandLine {
  std::filesystem::path config;
  std::vector<std::string> inputs;    // NAME=PATH, finally including those of the lists
  std::vector<std::string> in_lists;  // NAME=FILE
  std::vector<std::string> outputs;   // NAME=PATH
  std::vector<std::filesystem::path> in_list_files;
  int num_threads = 0;
  std::string log_level = "info";
  bool version = false;
  bool print_config = false;
  bool print_ports = false;
  bool check_config = false;
};

// The options of `app` fill `line`, which outlives it.
void DefineCommandLine(CLI::App& app, CommandLine* line);

// Text of --help below the options: ports, options of the config, exit codes.
std::string HelpFooter(const StageSpec& spec, const OptionList& options);

// Lines for --print-ports: in or out, name, kind, how many paths.
std::string PortLines(const StageSpec& spec);

// Adds the inputs that --in-list names. Throws UsageError as ReadInList does.
void ExpandInLists(CommandLine* line);

}  // namespace nightmap
