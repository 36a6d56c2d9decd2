// Values of clips and segments by the name of the field, and their comparison with a value of a
// filter, in the simplest way: the reference of server/filter.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tests/server/filter/random_records.h"

namespace motiondb::tests {

// A value as a filter writes it.
struct NaiveLiteral {
  std::string text;
  std::vector<bool> is_wildcard;  // of each byte
  bool is_quoted = false;
  // The times that it stands for, if it is a time or a date.
  std::optional<std::pair<std::int64_t, std::int64_t>> times_us;
};

struct NaiveField {
  bool is_list = false;   // != holds if no element is equal
  bool is_exact = false;  // `:` is =
  bool is_presence_of_key = false;
  std::vector<storage::FieldValue> values;
};

// `segment` is null for clips.
NaiveField NaiveFieldOf(const std::string& name, const StoredClip& clip,
                        const storage::SegmentRecord* segment);

// `comparator`: as written; "*" for presence.
bool NaiveCompare(const std::string& comparator, const NaiveField& field,
                  const NaiveLiteral& literal);

// Whether a text contains a literal, in any case.
bool NaiveContains(const std::string& text, const NaiveLiteral& literal);

}  // namespace motiondb::tests
