// SPDX-License-Identifier: Apache-2.0
// Options of a stage: each struct registers its fields once, and everything else (TOML parsing,
// --help, --print-config, range checks, the options page) iterates over that registration.
//
//   struct GridOptions {
//     double resolution_m = 0.05;
//     void Register(OptionList& list) {
//       list.Add("resolution_m", &resolution_m, Range(0.01, 1.0), "edge length of a cell");
//     }
//   };
#pragma once

#include <limits>
#include <string>
#include <string_view>
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
  void Add(std::string name, bool* value, std::string doc);
  void Add(std::string name, int* value, Range range, std::string doc);
  void Add(std::string name, double* value, Range range, std::string doc);
  void Add(std::string name, std::vector<int>* value, Range range, std::string doc);
  void Add(std::string name, std::vector<double>* value, Range range, std::string doc);
  void Add(std::string name, std::string* value, std::string doc);
  void Add(std::string name, std::vector<std::string>* value, std::string doc);
  void Add(std::string name, std::string* value, std::vector<std::string> choices, std::string doc);

  // The options that are added from now on stand behind option `name`, not at the end, so that a
  // stage can put its own beside those of a struct that it shares with others.
  void ContinueAfter(const std::string& name);

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

  // A table for --help: name, default, range, doc.
  std::string Help() const;

 private:
  void Insert(OptionSpec spec);
  std::vector<OptionSpec> specs_;
  std::size_t next_ = 0;  // index that the next option gets
};

template <typename Options>
OptionList RegisterOptions(Options& options) {
  OptionList list;
  options.Register(list);
  return list;
}

}  // namespace nightmap
