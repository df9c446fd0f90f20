// SPDX-License-Identifier: Apache-2.0
// Groups the items that a stage skipped by cause, so that 120 damaged frames take two lines of the
// log.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "pipeline/base/input_error.h"

namespace nightmap {

// A skipped item is a text "item: cause". Causes that differ only in their numbers are the same.
class SkippedItems {
 public:
  struct Cause {
    std::string text;        // text of the first item
    std::string first_item;  // empty when the text names no item
    std::size_t num_items = 0;
  };

  // Returns true when the cause is new.
  bool Add(const std::string& text);

  std::size_t Count() const { return texts_.size(); }
  const std::vector<std::string>& Texts() const { return texts_; }  // in order
  std::size_t NumCauses() const { return causes_.size(); }
  // Most frequent cause first; ties in order of their first item.
  std::vector<Cause> Causes() const;

  // Throws DataError with the most frequent cause when more than max_failed_ratio of num_items were
  // skipped: an InputError of `inputs` where items have no file of their own, as pictures do.
  void Check(std::size_t num_items,
             double max_failed_ratio,
             const std::vector<InputName>& inputs = {}) const;

 private:
  std::vector<std::string> texts_;
  std::vector<Cause> causes_;                 // in order of their first item
  std::map<std::string, std::size_t> kinds_;  // index of a cause by its text without numbers
};

// For messages: "120 items skipped: <cause>; the first is <item>".
std::string CauseText(const SkippedItems::Cause& cause);

}  // namespace nightmap
