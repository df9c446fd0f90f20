// SPDX-License-Identifier: Apache-2.0
// The columns of a log as csv that hold a sample.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pipeline/recording/signals_io.h"

namespace nightmap {

// Blanks around names and fields do not count.
class CsvColumns {
 public:
  // `columns` names the time and the values, comma separated; of a scan the time alone, because all
  // other columns are ranges. Throws UsageError when the header lacks one; `source` is the
  // file:line of the table that names them, `file` the log.
  CsvColumns(std::string_view header,
             const std::string& columns,
             SignalKind kind,
             const std::string& source,
             const std::string& file);

  // The fields of a line, the time first. Throws DataError unless it has as many as the header.
  std::vector<std::string_view> FieldsOf(std::string_view line) const;

 private:
  std::size_t num_columns_ = 0;
  std::vector<std::size_t> columns_;
};

}  // namespace nightmap
