// Reads lists of a store under test page by page.
#pragma once

#include <string>
#include <vector>

#include "storage/motion_store.h"
#include "tests/storage/conformance/motion_store_conformance.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests {

// Returns the ids or names of a list, read in pages of `limit`.
template <typename List, typename Key>
std::vector<std::string> AllPages(int limit, const List& list, const Key& key) {
  std::vector<std::string> keys;
  storage::Page page{.after = "", .limit = limit};
  while (true) {
    const auto records = Require(list(page));
    REQUIRE(static_cast<int>(records.size()) <= limit);
    for (const auto& record : records) keys.push_back(key(record));
    if (static_cast<int>(records.size()) < limit) return keys;
    page.after = keys.back();
  }
}

inline std::vector<std::string> ClipIds(StoreUnderTest& store, const std::string& database,
                                        int limit) {
  return AllPages(
      limit, [&](const storage::Page& page) { return store->ListClips(database, page); },
      [](const storage::ClipRecord& record) { return record.id; });
}

}  // namespace motiondb::tests
