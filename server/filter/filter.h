// Filters of clips and segments: expressions as in https://google.aip.dev/160. docs/filters.md has
// the fields, operators and examples.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/filter/predicate.h"

namespace motiondb::server {

enum class FilterSubject { kClips, kSegments };

// Immutable; copies share their state. Thread-safe.
class Filter {
 public:
  // The filter that all clips and segments pass.
  Filter() = default;

  // Parses a filter of at most kMaxFilterBytes; the empty one passes all. INVALID_ARGUMENT of the
  // field `filter` says the byte (from 1), what was expected, and what is there.
  static absl::StatusOr<Filter> Parse(std::string_view text, FilterSubject subject);

  bool passes_all() const { return predicate_ == nullptr; }
  // A filter of the same meaning in one form of writing; empty if all pass.
  const std::string& text() const { return text_; }

  // Number of steps of Passes for a clip, for core::ThrottledCancellation.
  std::int64_t StepsFor(const CatalogClip& clip) const {
    return step_count_ * (1 + static_cast<std::int64_t>(clip.segments.size()));
  }

  // For filters of clips. O(comparisons * segments of the clip).
  bool Passes(const CatalogClip& clip) const {
    return predicate_ == nullptr || Holds(*predicate_, clip, nullptr);
  }
  // For filters of segments; a segment of this clip.
  bool Passes(const CatalogClip& clip, const CatalogSegment& segment) const {
    return predicate_ == nullptr || Holds(*predicate_, clip, &segment);
  }

 private:
  std::shared_ptr<const Predicate> predicate_;  // null: all pass
  std::string text_;
  std::int64_t step_count_ = 8;  // for one segment
};

}  // namespace motiondb::server
