// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/stage_main.h"

#include <fmt/ranges.h>
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <stdexcept>
#include <thread>

#include "pipeline/base/memory.h"
#include "pipeline/base/plain_file.h"
#include "pipeline/program/command_line.h"
#include "pipeline/program/name_files.h"
#include "pipeline/program/run_cost.h"
#include "pipeline/program/stage_log.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Replaces names that are not UTF-8, because they must not cost the run its report.
std::string Dump(const json& value) {
  return value.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

json DescribeFile(const std::string& name, const fs::path& path, const fs::path& bytes_at) {
  json entry{{"name", name}, {"path", path.string()}};
  if (fs::is_regular_file(bytes_at)) {
    entry["size_bytes"] = fs::file_size(bytes_at);
    entry["xxh3"] = HashFile(bytes_at);
  }
  return entry;
}

}  // namespace

// One run of a stage program, from the command line to the committed receipt.
class StageRun {
 public:
  StageRun(const StageSpec& spec, const OptionList& options, const CommandLine& line)
      : spec_(spec), options_(options), line_(line) {}

  void Execute(const std::function<void(StageContext&)>& body) {
    StageContext context = MakeContext();
    if (!line_.config.empty()) context.files_.AddRead(line_.config, "--config");
    for (const fs::path& file : line_.in_list_files) context.files_.AddRead(file, "--in-list");
    spdlog::info("nightmap {} {} build, {} threads",
                 NIGHTMAP_VERSION,
                 NIGHTMAP_BUILD_TYPE,
                 context.num_threads_);
    context.RemoveFailureFile();
    if (context.HasOutput("receipt")) DescribeInputs(context);  // refuses what was not written so
    body(context);
    context.SumUpSkipped();
    context.BeginPart("commit");
    context.progress_.Finish();
    WriteReport(context);
    WriteReceipt(context);
    context.output_set_.Commit();
    spdlog::info("done in {:.1f} s", cost_.WallTime_s());
  }

 private:
  StageContext MakeContext() const {
    auto inputs = AssignPorts(line_.inputs, spec_.inputs, "--in");
    CheckInputs(inputs, spec_.inputs);
    std::map<std::string, fs::path> outputs;
    for (auto& [name, paths] : AssignPorts(line_.outputs, spec_.outputs, "--out")) {
      if (!paths.empty()) outputs[name] = paths.front();
    }
    const int num_cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    return {spec_,
            std::move(inputs),
            std::move(outputs),
            options_.ToToml(),
            line_.num_threads > 0 ? line_.num_threads : num_cores};
  }

  bool IsByHash(const std::string& input) const {
    return std::ranges::any_of(spec_.inputs, [&](const PortSpec& port) {
      return port.name == input && port.kind == PortKind::kByHash;
    });
  }

  // The hashes are those of before the body ran.
  json DescribeInputs(StageContext& context) const {
    json inputs = json::array();
    for (const auto& [name, paths] : context.inputs_) {
      for (const fs::path& path : paths) {
        json& entry = inputs.emplace_back(json{{"name", name}, {"path", path.string()}});
        if (IsByHash(name) || !fs::is_regular_file(path)) continue;
        entry["size_bytes"] = fs::file_size(path);
        entry["xxh3"] = context.written_inputs_.Hash(path);
      }
    }
    return inputs;
  }

  void WriteReport(StageContext& context) const {
    if (!context.HasOutput("report")) return;
    json report{{"format", "nightmap report"}, {"version", 1}, {"stage", spec_.name}};
    report["config"] = options_.ToToml();
    report["num_skipped"] = context.skipped_.Count();
    if (context.skipped_.Count() > 0) report["skipped"] = context.skipped_.Texts();
    report.update(context.report_);
    WriteFile(context.Output("report"), Dump(report));
  }

  void WriteReceipt(StageContext& context) const {
    if (!context.HasOutput("receipt")) return;
    json receipt{{"format", "nightmap receipt"}, {"version", 1}, {"stage", spec_.name}};
    receipt["program"] = DescribeFile(NIGHTMAP_VERSION, "/proc/self/exe", "/proc/self/exe");
    receipt["program"]["path"] = fs::read_symlink("/proc/self/exe").string();
    receipt["build_type"] = NIGHTMAP_BUILD_TYPE;
    receipt["config"] = options_.ToToml();
    receipt["threads"] = context.num_threads_;
    receipt["inputs"] = DescribeInputs(context);
    receipt["outputs"] = json::array();
    for (const fs::path& path : context.output_set_.FinalPaths()) {
      receipt["outputs"].push_back(
          DescribeFile(path.filename(), path, context.output_set_.CurrentPath(path)));
    }
    receipt["parts"] = json::array();
    for (const auto& part : context.parts_) {
      receipt["parts"].push_back({{"name", part.name},
                                  {"wall_time_s", part.wall_time_s},
                                  {"cpu_time_s", part.cpu_time_s}});
    }
    receipt.update(cost_.ForReceipt());
    WriteFile(context.Output("receipt"), Dump(receipt));
  }

  const StageSpec& spec_;
  const OptionList& options_;
  const CommandLine& line_;
  const RunCost cost_;
};

namespace {

int Fail(const std::string& message, ExitCode code) {
  spdlog::error("{}", message);
  return static_cast<int>(code);
}

std::string OutOfMemoryText(const std::string& what, const CommandLine& line) {
  constexpr std::size_t kMaxNamed = 3;
  const std::size_t num_named = std::min(line.inputs.size(), kMaxNamed);
  const std::vector<std::string> named(
      line.inputs.begin(), line.inputs.begin() + static_cast<std::ptrdiff_t>(num_named));
  return fmt::format(
      "{}{}{}{}; run on fewer threads (make THREADS=1), raise the limit of memory (ulimit -v, "
      "where "
      "one is set), set smaller shards (frames.shard_size) or tiles (tiles.edge_m), or use a "
      "machine with more, and run make again",
      what,
      named.empty() ? "" : " with the inputs ",
      fmt::join(named, ", "),
      num_named < line.inputs.size() ? ", ..." : "");
}

// Handles options that need no inputs; true when nothing else was asked for.
bool HandleQueries(const StageSpec& spec, const CommandLine& line, const OptionList& options) {
  if (line.version) {
    std::cout << spec.name << " (nightmap) " << NIGHTMAP_VERSION << '\n';
  } else if (line.print_config) {
    std::cout << options.ToCommentedToml();
  } else if (line.print_ports) {
    std::cout << PortLines(spec);
  } else if (line.check_config) {
    CheckFilesOfUser(line.inputs, spec.inputs);
    std::cout << (line.config.empty() ? "defaults" : line.config.string()) << ": ok\n";
  }
  return line.version || line.print_config || line.print_ports || line.check_config;
}

// A stage needs the same large buffers for each picture. By default the C library gives them back
// to the system each time and gets them anew, page by page: a third of the time that `features`
// takes of small pictures, a quarter of that of a whole map.
void KeepFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that it accepts
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

}  // namespace

int RunStage(int argc,
             char** argv,
             const StageSpec& stage_spec,
             OptionList options,
             const std::function<void(StageContext&)>& body) {
  StageSpec spec = stage_spec;
  spec.outputs.push_back({"report", "counts and quality figures (JSON)", Arity::kOptional});
  spec.outputs.push_back({"receipt", "hashes, times and memory of this run", Arity::kOptional});
  CommandLine line;
  CLI::App app(spec.summary, spec.name);
  DefineCommandLine(app, &line);
  app.footer(HelpFooter(spec, options));
  SetUpLog(spec.name, "info");
  KeepFreedMemory();
  try {
    app.parse(argc, argv);
    SetUpLog(spec.name, line.log_level);
    if (!line.config.empty() && !fs::exists(line.config)) {
      throw UsageError("{}: config file does not exist", line.config.string());
    }
    if (const std::string why = WhyNotPlain(line.config); !why.empty()) {
      throw UsageError("--config {}: {}, a file is needed", line.config.string(), why);
    }
    if (!line.config.empty()) options.ParseToml(ReadFile(line.config), line.config.string());
    if (HandleQueries(spec, line, options)) return 0;
    ExpandInLists(&line);
    StageRun(spec, options, line).Execute(body);
    return 0;
  } catch (const CLI::CallForHelp&) {
    std::cout << app.help();
    return 0;
  } catch (const CLI::ParseError& error) {
    return Fail(std::string(error.what()) + "; see --help", ExitCode::kUsageError);
  } catch (const InputError& error) {
    return Fail(NameFiles(error, line.inputs), error.Code());
  } catch (const Error& error) {
    return Fail(error.what(), error.Code());
  } catch (const OutOfMemory& error) {
    return Fail(OutOfMemoryText(error.what(), line), ExitCode::kDataError);
  } catch (const std::exception& error) {
    if (IsOutOfMemory(error)) {
      return Fail(OutOfMemoryText("out of memory", line), ExitCode::kDataError);
    }
    return Fail(error.what(), ExitCode::kDataError);
  }
}

}  // namespace nightmap
