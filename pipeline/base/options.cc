// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/options.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

template <typename... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <typename... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

// Shortest text that reads back as the same double and is a TOML float.
std::string DoubleToToml(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".einf") == std::string::npos) text += ".0";
  return text;
}

std::string Quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

template <typename T, typename ToText>
std::string ListToToml(const std::vector<T>& values, ToText to_text) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += (i ? ", " : "") + to_text(values[i]);
  }
  return text + "]";
}

std::string ValueToToml(const OptionPointer& pointer) {
  const auto int_to_text = [](int value) { return std::to_string(value); };
  return std::visit(Overloaded{[](bool* v) { return std::string(*v ? "true" : "false"); },
                               [](int* v) { return std::to_string(*v); },
                               [](double* v) { return DoubleToToml(*v); },
                               [](std::string* v) { return Quote(*v); },
                               [&](std::vector<int>* v) { return ListToToml(*v, int_to_text); },
                               [](std::vector<double>* v) { return ListToToml(*v, DoubleToToml); },
                               [](std::vector<std::string>* v) { return ListToToml(*v, Quote); }},
                    pointer);
}

const char* TypeName(const OptionPointer& pointer) {
  return std::visit(Overloaded{[](bool*) { return "true or false"; },
                               [](int*) { return "an integer"; },
                               [](double*) { return "a number"; },
                               [](std::string*) { return "a string"; },
                               [](std::vector<int>*) { return "a list of integers"; },
                               [](std::vector<double>*) { return "a list of numbers"; },
                               [](std::vector<std::string>*) { return "a list of strings"; }},
                    pointer);
}

bool Assign(const toml::node& node, int* out) {
  const auto value = node.value_exact<std::int64_t>();
  if (!value || *value < std::numeric_limits<int>::min() ||
      *value > std::numeric_limits<int>::max()) {
    return false;
  }
  *out = static_cast<int>(*value);
  return true;
}

bool Assign(const toml::node& node, double* out) {
  if (!node.is_number()) return false;
  *out = *node.value<double>();
  return true;
}

bool Assign(const toml::node& node, bool* out) {
  const auto value = node.value_exact<bool>();
  if (value) *out = *value;
  return value.has_value();
}

bool Assign(const toml::node& node, std::string* out) {
  const auto value = node.value_exact<std::string>();
  if (value) *out = *value;
  return value.has_value();
}

template <typename T>
bool Assign(const toml::node& node, std::vector<T>* out) {
  const toml::array* array = node.as_array();
  if (!array) return false;
  std::vector<T> values(array->size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!Assign(*array->get(i), &values[i])) return false;
  }
  *out = std::move(values);
  return true;
}

bool InRange(double value, const OptionSpec& spec) {
  return std::isfinite(value) && value >= spec.min && value <= spec.max;
}

bool IsValid(const OptionSpec& spec) {
  const auto in_range = [&](auto value) { return InRange(static_cast<double>(value), spec); };
  return std::visit(
      Overloaded{[](bool*) { return true; },
                 [&](int* v) { return in_range(*v); },
                 [&](double* v) { return in_range(*v); },
                 [&](std::string* v) {
                   return spec.choices.empty() || std::ranges::count(spec.choices, *v) > 0;
                 },
                 [&](std::vector<int>* v) { return std::ranges::all_of(*v, in_range); },
                 [&](std::vector<double>* v) { return std::ranges::all_of(*v, in_range); },
                 [](std::vector<std::string>*) { return true; }},
      spec.value);
}

std::string RangeText(const OptionSpec& spec) {
  if (!spec.choices.empty()) return fmt::format("one of {}", fmt::join(spec.choices, ", "));
  if (std::isinf(spec.min) && std::isinf(spec.max)) return "";
  return fmt::format("{} .. {}", spec.min, spec.max);
}

void CheckValue(const OptionSpec& spec, const std::string& where) {
  if (IsValid(spec)) return;
  throw UsageError("{}: {} = {} is out of range; give {}",
                   where,
                   spec.name,
                   ValueToToml(spec.value),
                   RangeText(spec));
}

// Lines of at most 100 characters.
std::string Comment(const std::string& text) {
  std::string lines = "#";
  std::size_t width = 1;
  std::istringstream words(text);
  for (std::string word; words >> word; width += 1 + word.size()) {
    if (width + 1 + word.size() > 100) {
      lines += "\n#";
      width = 1;
    }
    lines += " " + word;
  }
  return lines;
}

const OptionSpec& Find(const std::vector<OptionSpec>& specs,
                       const std::string& name,
                       const std::string& where) {
  const auto found = std::ranges::find(specs, name, &OptionSpec::name);
  if (found != specs.end()) return *found;
  std::vector<std::string> names;
  for (const OptionSpec& spec : specs) names.push_back(spec.name);
  throw UsageError("{}: unknown key '{}'; known keys: {}", where, name, fmt::join(names, ", "));
}

}  // namespace

void OptionList::Add(std::string name, OptionPointer value, std::string doc) {
  specs_.push_back({.name = std::move(name), .value = value, .choices = {}, .doc = std::move(doc)});
}

void OptionList::Add(std::string name, OptionPointer value, Range range, std::string doc) {
  specs_.push_back({std::move(name), value, range.min, range.max, {}, std::move(doc)});
}

void OptionList::Add(std::string name,
                     std::string* value,
                     std::vector<std::string> choices,
                     std::string doc) {
  specs_.push_back({.name = std::move(name),
                    .value = value,
                    .choices = std::move(choices),
                    .doc = std::move(doc)});
}

void OptionList::ParseToml(std::string_view text, const std::string& source) {
  toml::table table;
  try {
    table = toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    throw UsageError(
        "{}:{}: not valid TOML: {}", source, error.source().begin.line, error.description());
  }
  ParseTable(table, source);
}

void OptionList::ParseTable(const toml::table& table, const std::string& source) {
  for (const auto& [key, node] : table) {
    const std::string where = fmt::format("{}:{}", source, key.source().begin.line);
    const OptionSpec& spec = Find(specs_, std::string(key.str()), where);
    if (!std::visit([&node = node](auto* value) { return Assign(node, value); }, spec.value)) {
      throw UsageError("{}: '{}' must be {}", where, spec.name, TypeName(spec.value));
    }
    CheckValue(spec, where);
  }
}

void OptionList::Check(const std::string& source) const {
  for (const OptionSpec& spec : specs_) CheckValue(spec, source);
}

std::string OptionList::ToToml() const {
  std::string text;
  for (const OptionSpec& spec : specs_) {
    text += fmt::format("{} = {}\n", spec.name, ValueToToml(spec.value));
  }
  return text;
}

std::string OptionList::ToCommentedToml() const {
  std::string text;
  for (const OptionSpec& spec : specs_) {
    const std::string range = RangeText(spec);
    text += "\n" + Comment(spec.doc + (range.empty() ? "" : "; " + range)) + "\n";
    text += fmt::format("{} = {}\n", spec.name, ValueToToml(spec.value));
  }
  return text;
}

std::string OptionList::Help() const {
  std::size_t width = 0;
  for (const OptionSpec& spec : specs_) width = std::max(width, spec.name.size());
  std::string text;
  for (const OptionSpec& spec : specs_) {
    const std::string range = RangeText(spec);
    text += fmt::format("  {:<{}}  {} [default {}{}{}]\n",
                        spec.name,
                        width,
                        spec.doc,
                        ValueToToml(spec.value),
                        range.empty() ? "" : "; ",
                        range);
  }
  return text;
}

}  // namespace nightmap
