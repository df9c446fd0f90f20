// SPDX-License-Identifier: Apache-2.0
// What the body of a stage sees of the outside world: its inputs and outputs, its report, and the
// notes of what it skips and how far it is.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/atomic_outputs.h"
#include "pipeline/base/files.h"
#include "pipeline/base/progress.h"
#include "pipeline/program/files_of_run.h"
#include "pipeline/program/ports.h"
#include "pipeline/program/skipped.h"

namespace nightmap {

struct StageSpec {
  std::string name;
  std::string summary;
  std::vector<PortSpec> inputs;
  std::vector<PortSpec> outputs;  // `report` and `receipt` are added to every stage
};

class StageContext {
 public:
  // Throws UsageError when an output is no place for a file, an input, or another output.
  StageContext(StageSpec spec,
               PortPaths inputs,
               std::map<std::string, std::filesystem::path> outputs,
               std::string config_toml,
               int num_threads);

  // Path of a kOne input. Every input was checked to exist before the body runs.
  const std::filesystem::path& Input(const std::string& name) const;
  const std::vector<std::filesystem::path>& Inputs(const std::string& name) const;
  bool HasInput(const std::string& name) const;
  // A file that the input at `named_by` names. It is in the receipt like the other inputs, under
  // its file name. Throws DataError when it does not exist or is no file, UsageError when it is an
  // output.
  void AddInput(const std::filesystem::path& path, const std::filesystem::path& named_by);

  // Temporary path to write; renamed to the final one after the body returned.
  std::filesystem::path Output(const std::string& name);
  // For outputs whose number the stage decides: a file beside output `name`. Kept (time too) when
  // its bytes did not change. Throws UsageError when another file of the run has that path, or
  // something that is no plain file.
  std::filesystem::path OutputBeside(const std::string& name, const std::string& file_name);
  bool HasOutput(const std::string& name) const;
  // Writes the text that make() gives to an output, when the run has that output.
  template <typename Make>
  void WriteIfWanted(const std::string& name, const Make& make) {
    if (HasOutput(name)) WriteFile(Output(name), make());
  }
  std::filesystem::path FinalPath(const std::string& name) const;

  int NumThreads() const { return num_threads_; }
  // The effective config as TOML, to be carried by the artifacts.
  const std::string& ConfigToml() const { return config_toml_; }
  Progress& GetProgress() { return progress_; }

  // Deterministic quality figures: counts and numbers with units as suffixes; goes to report.json.
  nlohmann::json& Report() { return report_; }

  // Notes a skipped item, "item: cause". It is listed in the report and counted there as
  // num_skipped. The log has the first of each cause at once, and how many there were at the end;
  // each at level debug. CheckSkipped throws DataError when more than max_failed_ratio of the items
  // were skipped.
  void Skip(const std::string& text);
  void CheckSkipped(std::size_t num_items, double max_failed_ratio) const;

  // Names the part of the work that starts now, or goes on; wall time per part goes to
  // receipt.json.
  void BeginPart(const std::string& name);

 private:
  friend class StageRun;
  void SumUpSkipped() const;  // logs what the log has not said yet

  StageSpec spec_;
  PortPaths inputs_;
  std::map<std::string, std::filesystem::path> outputs_;
  std::string config_toml_;
  int num_threads_;
  FilesOfRun files_;
  OutputSet output_set_;
  Progress progress_;
  nlohmann::json report_ = nlohmann::json::object();
  SkippedItems skipped_;
  std::vector<std::pair<std::string, double>> parts_;  // name, seconds
  std::size_t current_part_ = 0;
  std::chrono::steady_clock::time_point part_start_;
};

}  // namespace nightmap
