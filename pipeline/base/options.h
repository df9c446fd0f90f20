// SPDX-License-Identifier: Apache-2.0
// Options of a stage: a struct whose fields say in one place their name, default, range and
// meaning. Everything else (TOML parsing, --help, --print-config, default configs, range checks) is
// made from that. Options come in the order of the fields.
//
//   struct GridOptions {
//     OPTION(double, resolution_m, 0.05, {0.01, 1.0}, "edge length of a cell");
//     OPTION(std::string, planner, "astar", {"astar", "any_angle"}, "how paths are searched");
//     OPTION(bool, thin_walls, false, "draws straight walls one cell wide");
//     OPTIONS_OF(WheelNoise, wheels, "wheel_");  // a struct of options
//
//     VocabularyTreeOptions tree;  // parameters of a library, one of them an option
//     OPTION_AT("depth", tree.depth, {1, 8}, "levels below the root");
//
//     REGISTER_OPTIONS();  // after all of them: void Register(OptionList&)
//   };
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace toml {
inline namespace v3 {
class table;  // toml++ is slow to compile, so only options.cc and readers of TOML include it
}
}  // namespace toml

namespace nightmap {

// Closed interval of valid values. For a list it bounds every element.
struct Range {
  Range(double min_value, double max_value) : min(min_value), max(max_value) {}
  double min;
  double max;
};

using OptionPointer = std::variant<bool*,
                                   int*,
                                   double*,
                                   std::string*,
                                   std::vector<int>*,
                                   std::vector<double>*,
                                   std::vector<std::string>*>;

struct OptionSpec {
  std::string name;  // with the unit as suffix: voxel_size_m, max_error_px
  OptionPointer value;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices;  // for a string option; empty: any
  std::string doc;                   // one line
};

class OptionList {
 public:
  void Add(std::string name, OptionPointer value, std::string doc);
  void Add(std::string name, OptionPointer value, Range range, std::string doc);
  void Add(std::string name, std::string* value, std::vector<std::string> choices, std::string doc);

  // All options of a struct, with `prefix` before their names.
  template <typename Options>
  void AddAll(Options& options, const std::string& prefix = "") {
    const std::size_t first = specs_.size();
    options.Register(*this);
    for (std::size_t i = first; i < specs_.size(); ++i) specs_[i].name.insert(0, prefix);
  }

  const std::vector<OptionSpec>& Specs() const { return specs_; }

  // Assigns the options named in a TOML document; options not named keep their value. `source`
  // names the document in messages. Throws UsageError with file:line on an unknown key, a wrong
  // type or a value out of range; repairs nothing.
  void ParseToml(std::string_view text, const std::string& source);

  // Likewise for one table of a parsed document (a site config has several).
  void ParseTable(const toml::table& table, const std::string& source);

  // Throws UsageError when a current value is out of range or not among the choices.
  void Check(const std::string& source) const;

  // The current values as TOML, in order of registration; ParseToml(ToToml()) is a fixed point.
  std::string ToToml() const;

  // The same with the meaning and range of each option as a comment above it.
  std::string ToCommentedToml() const;

  // A table for --help: name, default, range, doc.
  std::string Help() const;

 private:
  std::vector<OptionSpec> specs_;
};

template <typename Options>
OptionList RegisterOptions(Options& options) {
  OptionList list;
  options.Register(list);
  return list;
}

// The macros below give each line that declares an option a member function of its own, an overload
// for the type AtLine<line>; Register calls those of all lines up to its own. C++20 has no other
// way to go through the fields of a struct by name.
template <int line>
struct AtLine {};

#define OPTION_AT(name, field, ...)                                           \
  void RegisterLine(nightmap::AtLine<__LINE__>, nightmap::OptionList& list) { \
    list.Add(name, &field, __VA_ARGS__);                                      \
  }

#define OPTION(type, name, initial, ...) \
  type name = initial;                   \
  OPTION_AT(#name, name, __VA_ARGS__)

#define OPTIONS_AT(field, ...)                                                \
  void RegisterLine(nightmap::AtLine<__LINE__>, nightmap::OptionList& list) { \
    list.AddAll(field __VA_OPT__(, ) __VA_ARGS__);                            \
  }

#define OPTIONS_OF(type, name, ...) \
  type name;                        \
  OPTIONS_AT(name __VA_OPT__(, ) __VA_ARGS__)

#define REGISTER_OPTIONS()                                                               \
  template <int line>                                                                    \
  void RegisterLine(nightmap::AtLine<line>, nightmap::OptionList&) {}                    \
  template <int... lines>                                                                \
  void RegisterLines(std::integer_sequence<int, lines...>, nightmap::OptionList& list) { \
    (RegisterLine(nightmap::AtLine<lines>(), list), ...);                                \
  }                                                                                      \
  void Register(nightmap::OptionList& list) {                                            \
    RegisterLines(std::make_integer_sequence<int, __LINE__>(), list);                    \
  }

}  // namespace nightmap
