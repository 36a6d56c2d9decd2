// Pages of a list: sizes, and tokens that are opaque to the client but name the list that they
// belong to, so that one of another list is refused. A token of a model that has been replaced
// meanwhile is ABORTED. Safe to call from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "server/translate/resource_name.h"
#include "storage/records.h"

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

// A place in a list of one model's parts. A model is told by its version and its time: one that is
// not stored yet has the version of another.
struct ModelPosition {
  int version = 0;
  std::int64_t create_time_us = 0;  // 0: the list begins
  int index = 0;
};

std::string EncodeModelPosition(std::string_view scope, const ModelPosition& position);

// INVALID_ARGUMENT if the token was not given out for this list.
absl::StatusOr<ModelPosition> DecodeModelPosition(std::string_view scope, const std::string& token);

// The model to look for: on a later page the current one, whatever its version, so that a model
// that was replaced is found out by CheckStillCurrent.
ModelId PinnedTo(const ModelPosition& position, const ModelId& id);

// ABORTED if the position is of another model than `current`.
absl::Status CheckStillCurrent(const ModelPosition& position, const storage::ModelRecord& current);

}  // namespace motiondb::server
