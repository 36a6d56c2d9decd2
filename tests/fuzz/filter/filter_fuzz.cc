// Filters, orders and names of facets: printing and parsing again keeps the meaning.
#include "server/filter/listing.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

namespace {

using server::Filter;
using server::FilterSubject;
using server::ListOrder;

// Two clips with values of all fields, and three segments.
server::Catalog SmallCatalog() {
  std::vector<storage::ChangeRecord> changes(5);
  storage::ClipRecord clip;
  clip.id = "a";
  clip.subject = "07";
  clip.title = "Walk slowly";
  clip.description = "Hall 5";
  clip.file_name = "a.bvh";
  clip.frame_count = 100;
  clip.duration_seconds = 2.5;
  clip.create_time_us = 1'777'636'800'000'000;
  clip.tags = {"left", "slow"};
  clip.fields = {{"n", 4.0}, {"s", std::string("x")}, {"b", true}, {"t", storage::FieldTime{1}}};
  changes[0].change = storage::ClipPut{clip};
  clip.id = "b";
  clip.edit_time_us = 1;
  clip.tags.clear();
  changes[1].change = storage::ClipPut{clip};
  storage::SegmentRecord segment;
  segment.clip = "a";
  segment.id = "s";
  segment.label = "walk";
  changes[2].change = storage::SegmentPut{segment};
  segment.id = "t";
  segment.track = "carries";
  segment.label = "box";
  segment.end_seconds = 2;
  changes[3].change = storage::SegmentPut{segment};
  segment.clip = "b";
  changes[4].change = storage::SegmentPut{segment};
  return server::Catalog().With(changes);
}

void CheckFilter(std::string_view text, FilterSubject subject, const server::Catalog& catalog) {
  const auto filter = Filter::Parse(text, subject);
  tests::CheckErrorContract(filter.status(), absl::StatusCode::kInvalidArgument);
  if (!filter.ok()) return;
  Filter again = *filter;
  if (filter->text().size() <= server::kMaxFilterBytes) {
    const auto parsed = Filter::Parse(filter->text(), subject);
    tests::CheckContract(parsed.ok() && parsed->text() == filter->text(), "a filter round-trips");
    again = *parsed;
  }
  catalog.ForEach([&](const server::CatalogClip& clip) {
    if (subject == FilterSubject::kClips) {
      tests::CheckContract(filter->Passes(clip) == again.Passes(clip), "the same clips pass");
      return true;
    }
    for (const server::CatalogSegment& segment : clip.segments) {
      tests::CheckContract(filter->Passes(clip, segment) == again.Passes(clip, segment),
                           "the same segments pass");
    }
    return true;
  });
}

void CheckOrder(std::string_view text, FilterSubject subject, const server::Catalog& catalog) {
  const auto order = ListOrder::Parse(text, subject);
  tests::CheckErrorContract(order.status(), absl::StatusCode::kInvalidArgument);
  if (!order.ok()) return;
  const auto again = ListOrder::Parse(order->Text(), subject);
  tests::CheckContract(again.ok() && again->Text() == order->Text(), "an order round-trips");
  // The text is also a position that a client could send.
  const server::ListPart part{.after = std::string(text)};
  if (subject == FilterSubject::kClips) {
    const auto listed = server::ListClips(catalog, Filter(), *order, part);
    tests::CheckContract(listed.ok() && listed->total_count == 2, "all clips are counted");
  } else {
    const auto listed = server::ListSegments(catalog, "", Filter(), *order, part);
    tests::CheckContract(listed.ok() && listed->total_count == 3, "all segments are counted");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const server::Catalog kCatalog = SmallCatalog();
  const std::string_view text = tests::AsText(data, size);
  for (const FilterSubject subject : {FilterSubject::kClips, FilterSubject::kSegments}) {
    CheckFilter(text, subject, kCatalog);
    CheckOrder(text, subject, kCatalog);
  }
  const std::vector<std::string> names = {std::string(text)};
  tests::CheckErrorContract(server::ParseFacets(names).status(),
                            absl::StatusCode::kInvalidArgument);
  return 0;
}
