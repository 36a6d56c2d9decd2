// Random filters, written in random ways, and their naive evaluation.
#pragma once

#include <string>
#include <vector>

#include "server/filter/filter.h"
#include "tests/server/filter/naive_values.h"

namespace motiondb::tests {

struct NaiveFilter {
  enum class Kind { kAnd, kOr, kNot, kComparison, kValues, kSearch, kOneSegment };
  Kind kind = Kind::kSearch;
  std::vector<NaiveFilter> children;   // kOneSegment: one, of a segment
  std::string field;                   // kComparison, kValues
  std::string comparator;              // "*": presence
  std::vector<NaiveLiteral> literals;  // kValues: any of them
};

NaiveFilter RandomFilter(Random& random, server::FilterSubject subject, int depth);

// Writes a filter with random spaces, parentheses, quotes and forms of AND and NOT.
std::string WriteFilter(Random& random, const NaiveFilter& filter);

// `segment` is null for clips.
bool NaivePasses(const NaiveFilter& filter, const StoredClip& clip,
                 const storage::SegmentRecord* segment);

}  // namespace motiondb::tests
