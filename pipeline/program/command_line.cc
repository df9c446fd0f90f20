// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>

namespace nightmap {
namespace {

const char* Number(Arity arity) {
  if (arity == Arity::kOne) return "one";
  if (arity == Arity::kMany) return "many";
  return arity == Arity::kOptional ? "optional" : "any_number";
}

const char* Kind(PortKind kind) {
  if (kind == PortKind::kFolder) return "folder";
  return kind == PortKind::kByHash ? "by_hash" : "file";
}

std::string Lines(const char* direction, const std::vector<PortSpec>& ports) {
  std::string text;
  for (const PortSpec& port : ports) {
    const char* const kind = Kind(port.kind);
    text += fmt::format("{} {} {} {}\n", direction, port.name, kind, Number(port.arity));
  }
  return text;
}

}  // namespace

std::string HelpFooter(const StageSpec& spec, const OptionList& options) {
  return fmt::format(
      "inputs:\n{}\noutputs:\n{}{}\noptions in the config file (TOML):\n{}\n"
      "exit codes: 0 outputs committed; 1 data, I/O or numeric failure; 2 usage or "
      "config error; 3 below an acceptance threshold, nothing committed",
      PortHelp(spec.inputs),
      PortHelp(spec.outputs),
      spec.failure_file.empty()
          ? ""
          : fmt::format("a run that fails may leave {} beside the first of them\n",
                        spec.failure_file),
      options.Help());
}

void DefineCommandLine(CLI::App& app, CommandLine* line) {
  app.add_option("--config", line->config, "TOML file; options not named keep their default");
  app.add_option("--in", line->inputs, "NAME=PATH of an input")->take_all();
  app.add_option("--in-list", line->in_lists, "NAME=FILE: --in NAME=PATH for each line of FILE")
      ->take_all();
  app.add_option("--out", line->outputs, "NAME=PATH of an output")->take_all();
  app.add_option("--threads", line->num_threads, "0: one per core; never changes a result")
      ->check(CLI::Range(0, 1024));
  app.add_option("--log-level", line->log_level, "debug, info, warn, err or off")
      ->check(CLI::IsMember({"debug", "info", "warn", "err", "off"}));
  app.add_flag("--version", line->version, "print the version and exit");
  app.add_flag("--print-config", line->print_config, "print the effective config and exit");
  app.add_flag("--print-ports",
               line->print_ports,
               "print a line for each port (in or out, name, kind, how many paths) and exit");
  app.add_flag("--check-config",
               line->check_config,
               "check the config file, and the site config if --in gives it, and exit");
}

std::string PortLines(const StageSpec& spec) {
  return Lines("in", spec.inputs) + Lines("out", spec.outputs);
}

void ExpandInLists(CommandLine* line) {
  for (const std::string& text : line->in_lists) {
    InList list = ReadInList(text);
    std::ranges::move(list.inputs, std::back_inserter(line->inputs));
    line->in_list_files.push_back(std::move(list.file));
  }
}

}  // namespace nightmap
