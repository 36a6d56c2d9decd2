// Pages of a list: sizes, and tokens that are opaque to the client but name the list that they
// belong to, so that one of another list is refused. Safe to call from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"

namespace motiondb::server {

// How many items to return: 0 means `fallback`, more than `most` means `most`. INVALID_ARGUMENT if
// negative.
absl::StatusOr<int> PageSize(std::int32_t page_size, int fallback, int most);

// The token that continues the list `scope` after `position` (not empty).
std::string EncodePageToken(std::string_view scope, std::string_view position);

// The position in a token; empty for the empty token, which begins the list. INVALID_ARGUMENT if
// the token was not given out for this list.
absl::StatusOr<std::string> DecodePageToken(std::string_view scope, const std::string& token);

// Tells when a page is full: `size` items, or 2 MiB, since clients receive 4 MiB by default.
class PageBudget {
 public:
  explicit PageBudget(int size) : items_left_(size) {}
  // Whether an item of this many bytes fits. The first always does.
  bool Take(std::size_t bytes);

 private:
  int items_left_;
  std::size_t bytes_left_ = std::size_t{2} << 20;
  bool first_ = true;
};

// Adds to the repeated field `page` as many of `count` items as fit, item i made by make(i,
// message). Returns how many: if fewer than `count`, there is a next page.
template <typename Field, typename Make>
int FillPage(int count, int size, Field& page, const Make& make) {
  PageBudget budget(size);
  int taken = 0;
  for (; taken < count; ++taken) {
    typename Field::value_type message;
    make(taken, message);
    if (!budget.Take(message.ByteSizeLong())) break;
    *page.Add() = std::move(message);
  }
  return taken;
}

// The same of records that carry their own position in the list, of which one more than `size` was
// read so as to tell whether there is a next page. Returns its token, or nothing.
template <typename Records, typename Field, typename Make, typename Position>
std::string FillPageFrom(const Records& records, int size, std::string_view scope, Field& page,
                         const Make& make, const Position& position) {
  const int count = static_cast<int>(records.size());
  const int taken = FillPage(count, size, page, [&](int i, auto& to) { make(records[i], to); });
  return taken == count ? std::string() : EncodePageToken(scope, position(records[taken - 1]));
}

}  // namespace motiondb::server
