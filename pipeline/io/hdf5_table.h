// SPDX-License-Identifier: Apache-2.0
// Tables of HDF5 artifacts. A format declares the columns of its rows once; writing, reading and
// checking follow from that:
//
//   constexpr auto kPoints = Hdf5Table<Point>(
//       Hdf5Column("time_ns", &Point::time_ns).Pairs(Ascending(&Point::time_ns), "falls"),
//       Hdf5Column("position_m", &Point::x_m, &Point::y_m),
//       Hdf5Lists("first_view", &Point::views, Hdf5Table<int>(Hdf5Column("view", kItself))));
//
// The file has the arrays in this order. A list of lists is flat, after the array of where each
// list starts.
#pragma once

#include <functional>
#include <iterator>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/hdf5_stored.h"

namespace nightmap {

inline constexpr std::identity kItself;  // in place of a member: the row is the value
inline constexpr std::string_view kDoesNotFit = "is out of range or does not fit the others";

// The items of the lists of all rows, one after the other. (A view would not copy them, but views
// of GCC 12's library are none for clang 14.)
template <typename Rows, typename List>
auto Flattened(const Rows& rows, List list) {
  using Items = std::remove_cvref_t<decltype(std::invoke(list, *std::begin(rows)))>;
  std::vector<typename Items::value_type> items;
  for (const auto& row : rows) {
    const auto& of_row = std::invoke(list, row);
    items.insert(items.end(), of_row.begin(), of_row.end());
  }
  return items;
}

// A member of a member.
template <typename Outer, typename Inner>
constexpr auto MemberOf(Outer outer, Inner inner) {
  return [=](auto& row) -> auto& { return std::invoke(inner, std::invoke(outer, row)); };
}

// For Elements and Pairs of a column.
inline constexpr auto kNotNegative = [](auto value) { return value >= 0; };
inline constexpr auto kPositive = [](auto value) { return value > 0; };
template <typename Member>
constexpr auto Ascending(Member member) {
  return [=](const auto& before, const auto& row) {
    return std::invoke(member, before) < std::invoke(member, row);
  };
}

// An array of one or several members of each row, side by side.
template <typename Check, typename... Members>
class CheckedColumn {
 public:
  constexpr CheckedColumn(const char* name, std::tuple<Members...> members, Check check)
      : name_(name), members_(members), check_(check) {}

  // The column with one more check: `holds` of each of its numbers, of each row, or of each row and
  // the one before it. A reader refuses the array, and says why, where it does not.
  template <typename Holds>
  constexpr auto Elements(Holds holds, std::string_view why = kDoesNotFit) const {
    return With([=](const auto& demand, const auto& elements, const auto&) {
      for (const auto element : elements) demand(holds(element), why);
    });
  }
  template <typename Holds>
  constexpr auto Rows(Holds holds, std::string_view why = kDoesNotFit) const {
    return With([=](const auto& demand, const auto&, const auto& rows) {
      for (const auto& row : rows) demand(std::invoke(holds, row), why);
    });
  }
  template <typename Holds>
  constexpr auto Pairs(Holds holds, std::string_view why = kDoesNotFit) const {
    return With([=](const auto& demand, const auto&, const auto& rows) {
      for (std::size_t i = 1; i < rows.size(); ++i) demand(holds(rows[i - 1], rows[i]), why);
    });
  }

  template <typename Row, typename Range>
  void Write(Range&& rows, Hdf5Writer* file) const {
    Array<Element<Row>> array{0, kWidth<Row>, {}};
    const auto put = [&](const Row& row) {
      std::apply(
          [&](const auto&... member) { (Put(std::invoke(member, row), &array.values), ...); },
          members_);
      ++array.rows;
    };
    for (const auto& item : rows) {
      if constexpr (std::is_arithmetic_v<Row>) {
        put(static_cast<Row>(item));  // a character as a byte
      } else {
        put(item);
      }
    }
    file->Write(name_, array);
  }

  template <typename Row>
  void Read(const Hdf5Reader& file, bool is_first, std::vector<Row>* rows) const {
    const auto demand = [&](bool holds, std::string_view why) { file.Demand(holds, name_, why); };
    auto array = file.Read<Element<Row>>(name_, kWidth<Row>);
    if constexpr (kIsTheRow<Row>) {
      *rows = std::move(array.values);  // no copy: there may be a night of them
      check_(demand, *rows, *rows);
      return;
    }
    if (is_first) rows->resize(array.rows);
    file.Demand(array.rows == rows->size(), name_, "has another length than the others");
    const Element<Row>* from = array.values.data();
    for (std::size_t i = 0; i < rows->size(); ++i) {
      std::apply(
          [&](const auto&... member) {
            (Take(file, i, &from, &std::invoke(member, (*rows)[i])), ...);
          },
          members_);
    }
    check_(demand, array.values, *rows);
  }

 private:
  template <typename Row, typename Member>
  using StoredMember = Stored<std::remove_cvref_t<std::invoke_result_t<const Member&, const Row&>>>;
  template <typename Row>
  using Element = std::common_type_t<typename StoredMember<Row, Members>::Element...>;
  template <typename Row>
  static constexpr std::size_t kWidth = (0 + ... + StoredMember<Row, Members>::kWidth);
  // The column is the only one, and its numbers are the rows.
  template <typename Row>
  static constexpr bool kIsTheRow = std::is_same_v<Row, Element<Row>>&&
      std::is_same_v<std::tuple<Members...>, std::tuple<std::identity>>;

  template <typename T>
  static void Put(const T& value, auto* elements) {
    Stored<T>::Put(value, elements);
  }
  template <typename T>
  void Take(const Hdf5Reader& file, std::size_t row, const auto** from, T* value) const {
    if constexpr (requires { Stored<T>::IsOne(*from); }) {
      if (!Stored<T>::IsOne(*from)) file.FailRow(name_, row, Stored<T>::kOtherwise);
    }
    Stored<T>::Take(*from, value);
    *from += Stored<T>::kWidth;
  }

  template <typename More>
  constexpr auto With(More more) const {
    const auto both = [check = check_, more](const auto&... read) {
      check(read...);
      more(read...);
    };
    return CheckedColumn<decltype(both), Members...>(name_, members_, both);
  }

  const char* name_;
  std::tuple<Members...> members_;
  Check check_;
};

template <typename... Members>
constexpr auto Hdf5Column(const char* name, Members... members) {
  return CheckedColumn(name, std::tuple(members...), [](const auto&...) {});
}

template <typename Row, typename... Columns>
class ColumnsOf {
 public:
  explicit constexpr ColumnsOf(Columns... columns) : columns_(columns...) {}

  // `rows`: a range of rows, or of what converts to them.
  template <typename Range>
  void Write(Range&& rows, Hdf5Writer* file) const {
    std::apply([&](const auto&... column) { (column.template Write<Row>(rows, file), ...); },
               columns_);
  }
  // Throws DataError naming file and field on arrays of different lengths, and on what a check
  // refuses.
  std::vector<Row> Read(const Hdf5Reader& file) const {
    std::vector<Row> rows;
    bool is_first = true;
    std::apply(
        [&](const auto&... column) {
          (column.Read(file, std::exchange(is_first, false), &rows), ...);
        },
        columns_);
    return rows;
  }

 private:
  std::tuple<Columns...> columns_;
};

template <typename Row, typename... Columns>
constexpr auto Hdf5Table(Columns... columns) {
  return ColumnsOf<Row, Columns...>(columns...);
}

// A member of each row that is a list. Its name is that of the array of where each list starts, and
// the last one ends.
template <typename Offset, typename List, typename Items>
class ListColumn {
 public:
  constexpr ListColumn(const char* name, List list, Items items)
      : name_(name), list_(list), items_(items) {}

  template <typename Row, typename Range>
  void Write(Range&& rows, Hdf5Writer* file) const {
    const auto list_of = [&](const Row& row) -> const auto& { return std::invoke(list_, row); };
    std::vector<Offset> offsets = {0};
    for (const auto& row : rows) {
      offsets.push_back(offsets.back() + static_cast<Offset>(list_of(row).size()));
    }
    file->WriteList(name_, offsets);
    items_.Write(Flattened(rows, list_of), file);
  }

  template <typename Row>
  void Read(const Hdf5Reader& file, bool is_first, std::vector<Row>* rows) const {
    auto items = items_.Read(file);
    const auto size = is_first ? std::nullopt : std::optional(rows->size());
    const auto offsets = file.ReadOffsets<Offset>(name_, size, items.size());
    rows->resize(offsets.size() - 1);
    auto begin = std::make_move_iterator(items.begin());
    for (std::size_t i = 0; i < rows->size(); ++i) {
      const auto end = begin + static_cast<std::ptrdiff_t>(offsets[i + 1] - offsets[i]);
      std::invoke(list_, (*rows)[i]).assign(begin, end);
      begin = end;
    }
  }

 private:
  const char* name_;
  List list_;
  Items items_;
};

template <typename Offset = std::int64_t, typename List, typename Items>
constexpr auto Hdf5Lists(const char* name, List list, Items items) {
  return ListColumn<Offset, List, Items>(name, list, items);
}

}  // namespace nightmap
