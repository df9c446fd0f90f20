// SPDX-License-Identifier: Apache-2.0
// Reads and writes the project's CSV files: one header line, comma separated, fields with commas or
// quotes quoted (RFC 4180, but no line breaks in fields), every line terminated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace nightmap {

// Converts the whole text; nothing when the text is anything but one finite number.
std::optional<double> ParseReal(std::string_view text);
std::optional<std::int64_t> ParseInteger(std::string_view text);

// A field as written, quoted where needed. Throws DataError on a line break.
std::string CsvField(std::string_view text);

// One line of a CSV file. Columns count from 0. Errors are DataError naming file, line and column.
class CsvRow {
 public:
  CsvRow(std::string source, int line, const std::vector<std::string>* header)
      : source_(std::move(source)), line_(line), header_(header) {}

  const std::string& Text(std::size_t column) const { return fields_.at(column); }
  bool IsEmpty(std::size_t column) const { return Text(column).empty(); }
  std::int64_t Integer(std::size_t column) const;
  // An integer in [min, max of int].
  int Index(std::size_t column, int min = 0) const;
  double Real(std::size_t column) const;
  [[noreturn]] void Fail(const std::string& reason) const;

 private:
  friend class CsvFile;
  std::string source_;
  int line_;
  const std::vector<std::string>* header_;
  std::vector<std::string> fields_;
};

// A whole CSV file, checked: it has the required header, the same number of fields in every line,
// and a terminated last line (a truncated file is refused). With `may_have_more` further columns
// may follow.
class CsvFile {
 public:
  CsvFile(const std::filesystem::path& path, const std::string& header, bool may_have_more = false);
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;
  const std::vector<CsvRow>& Rows() const { return rows_; }
  const std::vector<std::string>& Header() const { return header_; }
  // The header line, for error messages.
  CsvRow HeaderRow() const { return {source_, 1, &header_}; }

 private:
  std::string source_;
  std::vector<std::string> header_;
  std::vector<CsvRow> rows_;
};

}  // namespace nightmap
