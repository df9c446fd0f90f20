// SPDX-License-Identifier: Apache-2.0
// Labels of an earlier run, so that a run asks the network only for pictures that have none yet.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "pipeline/io/labels_io.h"

namespace nightmap {

// A source is a hash of all that labels follow from: file, place in it, camera, network, program.
// No result depends on kept labels: equal sources have equal ones.
//
// CSV beside the file of labels, <labels>.sources.csv: time_ns,source,labels; the last is the hash
// of the labels, so that others at that time are not taken for them.
class KeptLabels {
 public:
  struct Found {
    PackedLabels packed;
    Segmentation labels;
  };

  KeptLabels() = default;  // none
  // `labels`: the file that this run will write. Missing or damaged files of the run before count
  // as empty.
  explicit KeptLabels(std::filesystem::path labels);

  // Nothing without labels of that source. Several threads may call it at once.
  std::optional<Found> Find(const std::string& source) const;

  // Writes `sources`, by time, of the labels of this run for the next. A folder that cannot be
  // written costs the next run time.
  void Save(const LabelsShard& labels, const std::map<std::int64_t, std::string>& sources) const;

 private:
  void Read();

  std::filesystem::path labels_;
  std::shared_ptr<const LabelsReader> reader_;
  std::map<std::string, PackedLabels> packed_;  // by source
};

}  // namespace nightmap
