// SPDX-License-Identifier: Apache-2.0
// Connects the body of a stage to its inputs and outputs, its report, its skipped items and its
// progress.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
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
#include "pipeline/program/skipped_items.h"
#include "pipeline/program/written_inputs.h"

namespace nightmap {

struct StageSpec {
  std::string name;
  std::string summary;
  std::vector<PortSpec> inputs;
  std::vector<PortSpec> outputs;  // every stage also has `report` and `receipt`
  // Name of the file beside the first output that tells more of why a run failed; a run removes
  // that of an earlier one when it begins.
  std::string failure_file = {};
};

class StageContext {
 public:
  // Throws UsageError when an output is not a valid place for a file, is an input, or is another
  // output.
  StageContext(StageSpec spec,
               PortPaths inputs,
               std::map<std::string, std::filesystem::path> outputs,
               std::string config_toml,
               int num_threads);

  // Path of a kOne input. Every input was checked to exist before the body runs.
  const std::filesystem::path& Input(const std::string& name) const;
  const std::vector<std::filesystem::path>& Inputs(const std::string& name) const;
  bool HasInput(const std::string& name) const;
  // Adds a file that the input at `named_by` refers to. The receipt lists it under its file name
  // like the other inputs. Throws DataError when it does not exist, is no file, or is not what the
  // job of the site wrote, UsageError when it is an output.
  void AddInput(const std::filesystem::path& path, const std::filesystem::path& named_by);

  // Returns the temporary path to write; it is renamed to the final one after the body returned.
  std::filesystem::path Output(const std::string& name);
  // Adds a file beside output `name`, for outputs whose number the stage decides. Keeps the
  // existing file (time too) if its bytes did not change. Throws UsageError when another file of
  // the run has that path, or the path holds something other than a plain file.
  std::filesystem::path OutputBeside(const std::string& name, const std::string& file_name);
  // Writes the spec's failure file by write(temporary path). A stage calls it before it throws, and
  // what prevents the file is only logged, so that it hides no reason.
  void LeaveFailureFile(const std::function<void(const std::filesystem::path&)>& write) const;
  bool HasOutput(const std::string& name) const;
  // Writes the text that make() returns to an output, if the run has that output.
  template <typename Make>
  void WriteIfWanted(const std::string& name, const Make& make) {
    if (HasOutput(name)) WriteFile(Output(name), make());
  }
  std::filesystem::path FinalPath(const std::string& name) const;

  int NumThreads() const { return num_threads_; }
  // The effective config as TOML, which artifacts carry.
  const std::string& ConfigToml() const { return config_toml_; }
  Progress& GetProgress() { return progress_; }

  // Deterministic quality figures for report.json: counts and numbers with units as suffixes.
  nlohmann::json& Report() { return report_; }

  // Notes a skipped item, "item: cause". The report lists it and counts it in num_skipped. The log
  // shows the first item of each cause at once, the number of each cause at the end, and every item
  // at level debug. CheckSkipped throws as SkippedItems::Check.
  void Skip(const std::string& text);
  void CheckSkipped(std::size_t num_items,
                    double max_failed_ratio,
                    const std::vector<InputName>& inputs = {}) const;

  // Names the part of the work that starts or resumes now; receipt.json has its time.
  void BeginPart(const std::string& name);

 private:
  friend class StageRun;
  void SumUpSkipped() const;  // logs the counts that are not logged yet
  std::filesystem::path FailurePath() const;
  void RemoveFailureFile() const;  // of an earlier run

  StageSpec spec_;
  PortPaths inputs_;
  std::map<std::string, std::filesystem::path> outputs_;
  std::string config_toml_;
  int num_threads_;
  FilesOfRun files_;
  WrittenInputs written_inputs_;
  OutputSet output_set_;
  Progress progress_;
  nlohmann::json report_ = nlohmann::json::object();
  SkippedItems skipped_;
  struct Part {
    std::string name;
    double wall_time_s = 0;
    double cpu_time_s = 0;
  };
  std::vector<Part> parts_;
  std::size_t current_part_ = 0;
  std::chrono::steady_clock::time_point part_start_;
  double cpu_time_at_part_start_s_ = 0;
};

}  // namespace nightmap
