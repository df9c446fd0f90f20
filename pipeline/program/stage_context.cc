// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/stage_context.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_file.h"
#include "pipeline/program/run_cost.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxCausesShown = 10;  // of skipped items, per log

std::string PortText(const char* flag, const std::string& name, const fs::path& path) {
  return fmt::format("{} {}={}", flag, name, path.string());
}

}  // namespace

StageContext::StageContext(StageSpec spec,
                           PortPaths inputs,
                           std::map<std::string, fs::path> outputs,
                           std::string config_toml,
                           int num_threads)
    : spec_(std::move(spec)),
      inputs_(std::move(inputs)),
      outputs_(std::move(outputs)),
      config_toml_(std::move(config_toml)),
      num_threads_(num_threads),
      written_inputs_(HasOutput("receipt") ? outputs_.at("receipt") : fs::path()),
      progress_(spec_.name),
      part_start_(Clock::now()) {
  for (const auto& [name, paths] : inputs_) {
    for (const fs::path& path : paths) files_.AddRead(path, PortText("--in", name, path));
  }
  for (const auto& [name, path] : outputs_) files_.AddWritten(path, PortText("--out", name, path));
  if (!spec_.failure_file.empty()) {
    const fs::path path = FailurePath();
    files_.AddWritten(path, path.string() + ", which a run that fails may write");
  }
}

const fs::path& StageContext::Input(const std::string& name) const {
  if (!HasInput(name)) {
    throw std::logic_error(fmt::format(
        "{}: input '{}' is used but was not given; a stage asks HasInput first", spec_.name, name));
  }
  return Inputs(name).front();
}

const std::vector<fs::path>& StageContext::Inputs(const std::string& name) const {
  return inputs_.at(name);
}

bool StageContext::HasInput(const std::string& name) const {
  const auto found = inputs_.find(name);
  return found != inputs_.end() && !found->second.empty();
}

void StageContext::AddInput(const fs::path& path, const fs::path& named_by) {
  if (!fs::exists(path)) {
    throw DataError("{}: {} names this file, but it does not exist; make it again or correct {}",
                    path.string(),
                    named_by.string(),
                    named_by.filename().string());
  }
  RequirePlain(path);
  files_.AddRead(path, fmt::format("{}, which {} names", path.string(), named_by.string()));
  if (HasOutput("receipt")) written_inputs_.Hash(path);
  inputs_[path.filename().string()].push_back(path);
}

fs::path StageContext::Output(const std::string& name) {
  return output_set_.Create(outputs_.at(name));
}

fs::path StageContext::OutputBeside(const std::string& name, const std::string& file_name) {
  const fs::path path = outputs_.at(name).parent_path() / file_name;
  files_.AddWritten(path, fmt::format("{}, written beside --out {}", path.string(), name));
  return output_set_.Create(path, true);
}

fs::path StageContext::FailurePath() const {
  return outputs_.at(spec_.outputs.front().name).parent_path() / spec_.failure_file;
}

void StageContext::RemoveFailureFile() const {
  std::error_code ignored;  // what cannot be removed is told when the next one is to be written
  if (!spec_.failure_file.empty()) fs::remove(FailurePath(), ignored);
}

void StageContext::LeaveFailureFile(const std::function<void(const fs::path&)>& write) const {
  const fs::path path = FailurePath();
  try {
    OutputSet set;
    write(set.Create(path));
    set.Commit();
    spdlog::warn("{} shows more", path.string());
  } catch (const std::exception& error) {
    spdlog::warn("{} is not written: {}", path.string(), error.what());
  }
}

bool StageContext::HasOutput(const std::string& name) const { return outputs_.contains(name); }

fs::path StageContext::FinalPath(const std::string& name) const { return outputs_.at(name); }

void StageContext::Skip(const std::string& text) {
  const bool is_new = skipped_.Add(text);
  const bool is_shown = is_new && skipped_.NumCauses() <= kMaxCausesShown;
  spdlog::log(is_shown ? spdlog::level::warn : spdlog::level::debug, "skipped: {}", text);
}

void StageContext::CheckSkipped(std::size_t num_items,
                                double max_failed_ratio,
                                const std::vector<InputName>& inputs) const {
  skipped_.Check(num_items, max_failed_ratio, inputs);
}

void StageContext::SumUpSkipped() const {
  const auto causes = skipped_.Causes();
  for (std::size_t i = 0; i < std::min(causes.size(), kMaxCausesShown); ++i) {
    if (causes[i].num_items > 1) spdlog::warn("{}", CauseText(causes[i]));
  }
  if (causes.size() > kMaxCausesShown) {
    spdlog::warn("items are skipped for {} more causes; the report lists every item",
                 causes.size() - kMaxCausesShown);
  }
}

void StageContext::BeginPart(const std::string& name) {
  const auto now = Clock::now();
  const double cpu_time_s = CpuTime_s();
  if (!parts_.empty()) {
    Part& part = parts_[current_part_];
    part.wall_time_s += std::chrono::duration<double>(now - part_start_).count();
    part.cpu_time_s += cpu_time_s - cpu_time_at_part_start_s_;
  }
  part_start_ = now;
  cpu_time_at_part_start_s_ = cpu_time_s;
  const auto found = std::ranges::find(parts_, name, &Part::name);
  current_part_ = static_cast<std::size_t>(found - parts_.begin());
  if (found == parts_.end()) parts_.push_back({name});
}

}  // namespace nightmap
