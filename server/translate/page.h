// Pages of a list: sizes and page tokens. A token is opaque to the client and contains the scope of
// its list, so that a token of another list is refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "server/engine/query/model_query.h"

namespace motiondb::server {

// Returns the number of items of a page: `fallback` for 0, at most `max_size`. Returns
// INVALID_ARGUMENT if negative.
absl::StatusOr<int> PageSize(std::int32_t page_size, int fallback, int max_size);

// Returns the token that continues the list `scope` after `position` (not empty).
std::string EncodePageToken(std::string_view scope, std::string_view position);

// Returns the position in a token; empty for the empty token, which is the beginning of the list.
// Returns INVALID_ARGUMENT if the token belongs to another list.
absl::StatusOr<std::string> DecodePageToken(std::string_view scope, const std::string& token);

// Limits a page to `size` items and 2 MiB, because clients receive at most 4 MiB by default.
class PageBudget {
 public:
  explicit PageBudget(int size) : items_left_(size) {}
  // Adds an item of `bytes` bytes. Returns false if it does not fit; the first item always fits.
  bool Take(std::size_t bytes);

 private:
  int items_left_;
  std::size_t bytes_left_ = std::size_t{2} << 20;
  bool first_ = true;
};

// Adds the first of `count` items that fit to the repeated field `page`; make(i, message) sets item
// i. Returns the number of added items: if it is less than `count`, there is a next page.
template <typename Field, typename Make>
int FillPage(int count, int size, Field& page, const Make& make) {
  PageBudget budget(size);
  int added = 0;
  for (; added < count; ++added) {
    typename Field::value_type message;
    make(added, message);
    if (!budget.Take(message.ByteSizeLong())) break;
    *page.Add() = std::move(message);
  }
  return added;
}

// Like FillPage, for items that make(item, message) reads from the store. An item that was deleted
// meanwhile, for which it returns NOT_FOUND, is left out. Returns how many items have been used; if
// it is less than their number, there is a next page.
template <typename Items, typename Field, typename Make>
absl::StatusOr<std::size_t> FillPageFromStore(const Items& items, int size, Field& page,
                                              const Make& make) {
  PageBudget budget(size);
  std::size_t used = 0;
  for (; used < items.size(); ++used) {
    typename Field::value_type message;
    const absl::Status made = make(items[used], message);
    if (!made.ok() && !absl::IsNotFound(made)) return made;
    if (!budget.Take(message.ByteSizeLong())) break;
    if (made.ok()) *page.Add() = std::move(message);
  }
  return used;
}

// Like FillPage, for records; position(record) is the position of a record in the list. `records`
// has up to `size` + 1 records, so that a next page is known. Returns the token of the next page,
// or an empty string.
template <typename Records, typename Field, typename Make, typename Position>
std::string FillPageFrom(const Records& records, int size, std::string_view scope, Field& page,
                         const Make& make, const Position& position) {
  const int count = static_cast<int>(records.size());
  const int added = FillPage(count, size, page, [&](int i, auto& to) { make(records[i], to); });
  return added == count ? std::string() : EncodePageToken(scope, position(records[added - 1]));
}

// Like FillPageFrom, for large records, of which read(after) returns the next few: those after the
// position `after`, none at the end.
template <typename Field, typename Read, typename Make, typename Position>
absl::StatusOr<std::string> FillPageByReads(std::string after, int size, std::string_view scope,
                                            Field& page, const Read& read, const Make& make,
                                            const Position& position) {
  PageBudget budget(size);
  while (true) {
    const auto records = read(after);
    if (!records.ok()) return records.status();
    if (records->empty()) return std::string();
    for (const auto& record : *records) {
      typename Field::value_type message;
      make(record, message);
      if (!budget.Take(message.ByteSizeLong())) return EncodePageToken(scope, after);
      *page.Add() = std::move(message);
      after = position(record);
    }
  }
}

// A position in a list of parts of one model.
struct ModelPosition {
  ModelStamp model;  // none: beginning of the list
  int index = 0;
};

std::string EncodeModelPosition(std::string_view scope, const ModelPosition& position);

// Returns INVALID_ARGUMENT if the token belongs to another list.
absl::StatusOr<ModelPosition> DecodeModelPosition(std::string_view scope, const std::string& token);

}  // namespace motiondb::server
