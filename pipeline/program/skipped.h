// SPDX-License-Identifier: Apache-2.0
// The items that a stage skipped, folded by cause: a log of 120 damaged frames has two lines of
// them.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace nightmap {

// A skipped item is told as text "item: cause". Causes that differ in their numbers only are one.
class SkippedItems {
 public:
  struct Cause {
    std::string text;        // of the first item
    std::string first_item;  // empty when the text names none
    std::size_t num_items = 0;
  };

  // True when the cause is new.
  bool Add(const std::string& text);

  std::size_t Count() const { return texts_.size(); }
  const std::vector<std::string>& Texts() const { return texts_; }  // in order
  std::size_t NumCauses() const { return causes_.size(); }
  // The most frequent first; equally frequent ones in order of their first item.
  std::vector<Cause> Causes() const;

  // Throws DataError with the most frequent cause when more than max_failed_ratio of num_items were
  // skipped.
  void Check(std::size_t num_items, double max_failed_ratio) const;

 private:
  std::vector<std::string> texts_;
  std::vector<Cause> causes_;                 // in order of their first item
  std::map<std::string, std::size_t> kinds_;  // place of the cause by its text without numbers
};

// For messages: "120 items skipped: <cause>; the first is <item>".
std::string CauseText(const SkippedItems::Cause& cause);

}  // namespace nightmap
