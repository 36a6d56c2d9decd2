#include "tests/server/filter/random_records.h"

#include <fmt/format.h>

#include <algorithm>

namespace motiondb::tests {
namespace {

constexpr const char* kRecordWords[] = {"",    "walk",  "Walk",    "walk slowly",
                                        "run", "jump*", "a\"b\\c", "\xc3\xa4rm"};
constexpr const char* kRecordTags[] = {"left", "left-hand", "slow", "v1.2"};
constexpr double kRecordSeconds[] = {0, 0.5, 1, 2.5, 10};
constexpr std::int64_t kRecordDayUs = 86'400'000'000;

std::string RandomWord(Random& random) { return OneOf(random, kRecordWords); }

std::int64_t RandomTime(Random& random) {
  constexpr std::int64_t kFirstDay = 20'575;  // 2026-05-02
  return (kFirstDay + Below(random, 3)) * kRecordDayUs + Below(random, 3) * (kRecordDayUs / 2) -
         Below(random, 2);
}

storage::FieldValue RandomFieldValue(Random& random) {
  switch (Below(random, 4)) {
    case 0:
      return RandomWord(random);
    case 1:
      return OneOf(random, kRecordSeconds) - 1;
    case 2:
      return Below(random, 2) == 0;
    default:
      return storage::FieldTime{RandomTime(random)};
  }
}

}  // namespace

int Below(Random& random, int count) {
  return std::uniform_int_distribution<int>(0, count - 1)(random);
}

storage::ClipRecord RandomClip(Random& random, const std::string& id) {
  storage::ClipRecord clip;
  clip.database = "db";
  clip.id = id;
  clip.subject = RandomWord(random);
  clip.title = RandomWord(random);
  clip.description = RandomWord(random) + " " + RandomWord(random);
  clip.file_name = RandomWord(random) + ".bvh";
  clip.given.take = RandomWord(random);
  clip.format = Below(random, 2) == 0 ? core::FileFormat::kBvh : core::FileFormat::kCollada;
  clip.frame_count = Below(random, 4) * 100;
  clip.duration_seconds = OneOf(random, kRecordSeconds);
  clip.create_time_us = RandomTime(random);
  clip.edit_time_us = Below(random, 2) == 0 ? 0 : RandomTime(random);
  for (const char* tag : kRecordTags) {
    if (Below(random, 3) == 0) clip.tags.emplace_back(tag);
  }
  std::sort(clip.tags.begin(), clip.tags.end());
  for (const char* name : {"score", "x"}) {
    if (Below(random, 3) > 0) clip.fields[name] = RandomFieldValue(random);
  }
  return clip;
}

storage::SegmentRecord RandomSegment(Random& random, const std::string& clip,
                                     const std::string& id) {
  storage::SegmentRecord segment;
  segment.database = "db";
  segment.clip = clip;
  segment.id = id;
  segment.track = Below(random, 2) == 0 ? storage::kActionTrack : "carries";
  do {
    segment.label = RandomWord(random);
  } while (segment.label.empty());
  segment.start_seconds = OneOf(random, kRecordSeconds);
  if (Below(random, 2) == 0)
    segment.end_seconds = segment.start_seconds + OneOf(random, kRecordSeconds);
  segment.source = static_cast<storage::SegmentSource>(1 + Below(random, 3));
  segment.confidence = OneOf(random, std::vector<double>{0.25, 0.5, 1});
  segment.author = RandomWord(random);
  segment.create_time_us = RandomTime(random);
  segment.update_time_us = RandomTime(random);
  return segment;
}

StoredClip RandomStoredClip(Random& random, const std::string& id) {
  StoredClip clip{.record = RandomClip(random, id)};
  const int count = Below(random, 4);
  for (int i = 0; i < count; ++i) {
    clip.segments.push_back(RandomSegment(random, id, fmt::format("s{}", i)));
  }
  return clip;
}

std::vector<storage::ChangeRecord> ChangesOf(const StoredClip& clip) {
  std::vector<storage::ChangeRecord> changes(1 + clip.segments.size());
  changes[0].change = storage::ClipPut{clip.record};
  for (std::size_t i = 0; i < clip.segments.size(); ++i) {
    changes[i + 1].change = storage::SegmentPut{clip.segments[i]};
  }
  for (storage::ChangeRecord& change : changes) change.revision = 1;
  return changes;
}

server::Catalog CatalogOf(const StoredClips& clips) {
  std::vector<storage::ChangeRecord> changes;
  for (const auto& [id, clip] : clips) {
    for (storage::ChangeRecord& change : ChangesOf(clip)) changes.push_back(std::move(change));
  }
  return server::Catalog().With(changes);
}

}  // namespace motiondb::tests
