// Annotations as text.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/model/model.h"
#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests {
namespace {

std::string DescribeValue(const storage::FieldValue& value) {
  if (const auto* const text = std::get_if<std::string>(&value)) return "'" + *text + "'";
  if (const auto* const number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  if (const auto* const flag = std::get_if<bool>(&value)) return *flag ? "yes" : "no";
  return fmt::format("@{}", std::get<storage::FieldTime>(value).time_us);
}

}  // namespace

std::string Describe(const storage::ClipRecord& clip) {
  std::string fields;
  for (const auto& [name, value] : clip.fields) fields += " " + name + "=" + DescribeValue(value);
  return fmt::format("{} label '{}' subject '{}' title '{}' description '{}' tags [{}]{} r{} t{}",
                     clip.id, clip.label, clip.subject, clip.title, clip.description,
                     fmt::join(clip.tags, " "), fields, clip.revision, clip.edit_time_us);
}

std::string Describe(const storage::SegmentRecord& segment) {
  const std::string end = segment.end_seconds ? fmt::format("{}", *segment.end_seconds) : "end";
  return fmt::format("{}/{} {} '{}' {} to {} source {} confidence {} r{} by '{}' t{} t{}",
                     segment.clip, segment.id, segment.track, segment.label, segment.start_seconds,
                     end, static_cast<int>(segment.source), segment.confidence, segment.revision,
                     segment.author, segment.create_time_us, segment.update_time_us);
}

std::string DumpAnnotations(storage::MotionStore& store, const std::string& database) {
  std::string text;
  for (const auto& clip : Require(store.ListClips(database, {.limit = 1000}))) {
    text += Describe(clip) + "\n";
    for (const auto& segment : Require(store.annotations().ListSegments(database, clip.id))) {
      text += "  " + Describe(segment) + "\n";
    }
  }
  return text;
}

}  // namespace motiondb::tests
