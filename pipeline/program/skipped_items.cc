// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/skipped_items.h"

#include <fmt/format.h>

#include <algorithm>

namespace nightmap {
namespace {

SkippedItems::Cause SplitText(const std::string& text) {
  const auto colon = text.find(": ");
  if (colon == std::string::npos) return {.text = text, .first_item = {}};
  return {.text = text.substr(colon + 2), .first_item = text.substr(0, colon)};
}

// Texts of one cause may name different files and measured values.
std::string WithoutNumbers(const std::string& text) {
  std::string kind;
  for (const char c : text) {
    const bool is_digit = '0' <= c && c <= '9';
    if (!is_digit) kind += c;
    if (is_digit && (kind.empty() || kind.back() != '0')) kind += '0';
  }
  return kind;
}

}  // namespace

bool SkippedItems::Add(const std::string& text) {
  texts_.push_back(text);
  Cause cause = SplitText(text);
  const auto [kind, is_new] = kinds_.try_emplace(WithoutNumbers(cause.text), causes_.size());
  if (is_new) causes_.push_back(std::move(cause));
  ++causes_[kind->second].num_items;
  return is_new;
}

std::vector<SkippedItems::Cause> SkippedItems::Causes() const {
  std::vector<Cause> causes = causes_;
  std::ranges::stable_sort(causes, std::ranges::greater(), &Cause::num_items);
  return causes;
}

void SkippedItems::Check(std::size_t num_items,
                         double max_failed_ratio,
                         const std::vector<InputName>& inputs) const {
  const auto num_all = static_cast<double>(std::max<std::size_t>(1, num_items));
  if (static_cast<double>(Count()) / num_all <= max_failed_ratio) return;
  const auto causes = Causes();
  const std::size_t num_other = causes.size() - 1;
  const std::string other =
      num_other == 0
          ? std::string()
          : fmt::format(" ({} other {})", num_other, num_other == 1 ? "cause" : "causes");
  const std::string text = fmt::format(
      "{} of {} items were skipped, more than max_failed_ratio = {} allows; {}{}; repair them{}; "
      "with --log-level debug (make LOG_LEVEL=debug) the log names each",
      Count(),
      num_items,
      max_failed_ratio,
      CauseText(causes.front()),
      other,
      Count() < num_items ? " or raise max_failed_ratio" : "");
  if (inputs.empty()) throw DataError("{}", text);
  throw InputError(inputs, InputError::Remedy::kInText, "{}", text);
}

std::string CauseText(const SkippedItems::Cause& cause) {
  return fmt::format("{} {} skipped: {}{}{}",
                     cause.num_items,
                     cause.num_items == 1 ? "item" : "items",
                     cause.text,
                     cause.first_item.empty() ? "" : "; the first is ",
                     cause.first_item);
}

}  // namespace nightmap
