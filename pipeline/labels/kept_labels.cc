// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/kept_labels.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "pipeline/base/atomic_outputs.h"
#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr const char* kSourcesHeader = "time_ns,source,labels";

std::filesystem::path SourcesOf(std::filesystem::path labels) {
  return labels.replace_extension(".sources.csv");
}

}  // namespace

KeptLabels::KeptLabels(std::filesystem::path labels) : labels_(std::move(labels)) {
  try {
    if (std::filesystem::exists(labels_) && std::filesystem::exists(SourcesOf(labels_))) Read();
  } catch (const Error& error) {
    spdlog::info("every frame is labelled anew: {}", error.what());
    packed_.clear();
  }
}

void KeptLabels::Read() {
  reader_ = std::make_shared<const LabelsReader>(labels_);
  const CsvFile csv(SourcesOf(labels_), kSourcesHeader);
  for (const CsvRow& row : csv.Rows()) {
    // A run that was killed may have left the sources of labels that it did not.
    if (!std::ranges::binary_search(
            reader_->Frames(), row.Integer(0), {}, &PackedLabels::time_ns)) {
      continue;
    }
    PackedLabels packed = reader_->ReadPacked(row.Integer(0));
    if (HashOf(packed, reader_->Classes().names) != row.Text(2)) continue;
    packed_[row.Text(1)] = std::move(packed);
  }
}

std::optional<KeptLabels::Found> KeptLabels::Find(const std::string& source) const {
  const auto packed = packed_.find(source);
  if (packed == packed_.end()) return std::nullopt;
  return Found{packed->second, reader_->Unpack(packed->second)};
}

void KeptLabels::Save(const LabelsShard& labels,
                      const std::map<std::int64_t, std::string>& sources) const {
  if (labels_.empty()) return;
  std::string text = std::string(kSourcesHeader) + '\n';
  for (const PackedLabels& frame : labels.frames) {
    text += fmt::format("{},{},{}\n",
                        frame.time_ns,
                        sources.at(frame.time_ns),
                        HashOf(frame, labels.classes.names));
  }
  try {
    OutputSet files;
    WriteFile(files.Create(SourcesOf(labels_), true), text);
    files.Commit();
  } catch (const Error& error) {
    spdlog::warn("the labels of this run are not kept for the next: {}", error.what());
  }
}

}  // namespace nightmap
