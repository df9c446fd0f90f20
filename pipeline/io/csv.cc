// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/io/text_file.h"

namespace nightmap {
namespace {

template <typename T>
std::optional<T> ParseNumber(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Nothing when a quote is not closed, or is followed by more text.
std::optional<std::vector<std::string>> SplitLine(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false, closed = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c != '"') {
        fields.back() += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += line[++i];
      } else {
        quoted = false;
        closed = true;
      }
    } else if (c == ',') {
      fields.emplace_back();
      closed = false;
    } else if (c == '"' && fields.back().empty() && !closed) {
      quoted = true;
    } else if (closed) {
      return std::nullopt;
    } else {
      fields.back() += c;
    }
  }
  if (quoted) return std::nullopt;
  return fields;
}

bool StartsWith(const std::vector<std::string>& fields, const std::vector<std::string>& start) {
  return fields.size() >= start.size() && std::equal(start.begin(), start.end(), fields.begin());
}

}  // namespace

std::optional<double> ParseReal(std::string_view text) {
  const auto value = ParseNumber<double>(text);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  return value;
}

std::optional<std::int64_t> ParseInteger(std::string_view text) {
  return ParseNumber<std::int64_t>(text);
}

std::string CsvField(std::string_view text) {
  if (text.find_first_of("\r\n") != std::string_view::npos) {
    throw DataError("'{}' holds a line break and cannot go into a CSV file: rename it", text);
  }
  if (text.find_first_of(",\"") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

void CsvRow::Fail(const std::string& reason) const {
  throw DataError("{}:{}: {}", source_, line_, reason);
}

std::int64_t CsvRow::Integer(std::size_t column) const {
  const auto value = ParseInteger(Text(column));
  if (!value) Fail(fmt::format("{} is '{}', not an integer", header_->at(column), Text(column)));
  return *value;
}

int CsvRow::Index(std::size_t column, int min) const {
  const std::int64_t value = Integer(column);
  if (value < min || value > std::numeric_limits<int>::max()) {
    Fail(fmt::format("{} is {}, out of range", header_->at(column), value));
  }
  return static_cast<int>(value);
}

double CsvRow::Real(std::size_t column) const {
  const auto value = ParseReal(Text(column));
  if (!value) {
    Fail(fmt::format("{} is '{}', not a finite number", header_->at(column), Text(column)));
  }
  return *value;
}

CsvFile::CsvFile(const std::filesystem::path& path, const std::string& header, bool may_have_more)
    : source_(path.string()) {
  header_ = *SplitLine(header);
  const std::string text = ReadTextFile(path);
  if (text.empty() || text.back() != '\n') {
    throw DataError("{}: the last line has no end: the file is empty or truncated", path.string());
  }
  int line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    std::string_view line(text.data() + begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    begin = end + 1;
    CsvRow row(source_, ++line_number, &header_);
    auto fields = SplitLine(line);
    if (!fields) row.Fail("a quote is not closed or not at the ends of a field");
    if (line_number == 1) {
      if (!StartsWith(*fields, header_) || (fields->size() > header_.size() && !may_have_more)) {
        row.Fail(
            fmt::format("the header must {} '{}'", may_have_more ? "begin with" : "be", header));
      }
      header_ = std::move(*fields);
      continue;
    }
    if (fields->size() != header_.size()) {
      row.Fail(fmt::format("{} fields, expected {}", fields->size(), header_.size()));
    }
    row.fields_ = std::move(*fields);
    rows_.push_back(std::move(row));
  }
}

}  // namespace nightmap
