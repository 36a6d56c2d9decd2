#include "server/filter/filter.h"

#include <utility>

#include "core/motion/error.h"
#include "server/filter/compile_filter.h"
#include "server/filter/syntax.h"

namespace motiondb::server {
namespace {

constexpr std::int64_t kStepsOfPredicate = 8;

std::int64_t PredicateCount(const Predicate& predicate) {
  std::int64_t count = 1;
  for (const Predicate& child : predicate.children) count += PredicateCount(child);
  return count;
}

}  // namespace

absl::StatusOr<Filter> Filter::Parse(std::string_view text, FilterSubject subject) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto syntax, ParseFilterSyntax(text));
  Filter filter;
  if (!syntax.has_value()) return filter;
  const FieldScope scope =
      subject == FilterSubject::kClips ? FieldScope::kClip : FieldScope::kSegment;
  MOTIONDB_ASSIGN_OR_RETURN(Predicate predicate, CompileFilter(*syntax, scope));
  filter.step_count_ = kStepsOfPredicate * PredicateCount(predicate);
  filter.predicate_ = std::make_shared<const Predicate>(std::move(predicate));
  filter.text_ = PrintFilter(*syntax);
  return filter;
}

}  // namespace motiondb::server
