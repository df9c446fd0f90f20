// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/csv_columns.h"

#include <algorithm>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view WithoutBlanks(std::string_view field) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t begin = std::min(field.find_first_not_of(kBlanks), field.size());
  return field.substr(begin, field.find_last_not_of(kBlanks) + 1 - begin);
}

std::vector<std::string_view> SplitAtCommas(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(WithoutBlanks(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return fields;
}

}  // namespace

CsvColumns::CsvColumns(std::string_view header,
                       const std::string& columns,
                       SignalKind kind,
                       const std::string& source,
                       const std::string& file) {
  if (header.starts_with(kByteOrderMark)) header.remove_prefix(kByteOrderMark.size());
  const std::vector<std::string_view> names = SplitAtCommas(header);
  num_columns_ = names.size();
  for (const std::string_view name : SplitAtCommas(columns)) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
      throw UsageError(
          "{}: {} has no column '{}', it has: {}", source, file, name, header.substr(0, 200));
    }
    columns_.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  if (kind != SignalKind::kScan) return;
  const std::size_t time = columns_.front();
  for (std::size_t i = 0; i < num_columns_; ++i) {
    if (i != time) columns_.push_back(i);
  }
}

std::vector<std::string_view> CsvColumns::FieldsOf(std::string_view line) const {
  const std::vector<std::string_view> all = SplitAtCommas(line);
  if (all.size() != num_columns_) {
    throw DataError("{} fields, expected {}", all.size(), num_columns_);
  }
  std::vector<std::string_view> fields;
  for (const std::size_t column : columns_) fields.push_back(all[column]);
  return fields;
}

}  // namespace nightmap
