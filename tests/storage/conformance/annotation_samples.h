// Clips, and changes of their annotations, of the conformance tests of annotations.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/motion/error.h"
#include "storage/annotation_store.h"
#include "tests/storage/conformance/motion_store_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {

// A database with the clips "walk" and "run" of 1.2 s and 60 frames, with label "walk".
inline void MakeClips(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  auto walk = SampleClip("d", "walk", 1);
  walk.author = "tokens/importer";
  REQUIRE_OK(store->AddClip(walk));
  REQUIRE_OK(store->AddClip(SampleClip("d", "run", 2)));
}

inline absl::StatusOr<storage::EditRecord> Edit(StoreUnderTest& store,
                                                const std::vector<storage::Change>& changes) {
  return store->annotations().Edit("d", changes, "tokens/me");
}

inline storage::SegmentCreation Create(const std::string& id, const std::string& label,
                                       double start, std::optional<double> end,
                                       const std::string& track = "action") {
  storage::SegmentCreation creation;
  creation.segment.clip = "walk";
  creation.segment.id = id;
  creation.segment.track = track;
  creation.segment.label = label;
  creation.segment.start_seconds = start;
  creation.segment.end_seconds = end;
  return creation;
}

inline storage::SegmentChange ChangeOf(const std::string& id) {
  storage::SegmentChange change;
  change.clip = "walk";
  change.id = id;
  return change;
}

inline storage::SegmentDeletion Delete(const std::string& id, std::int64_t revision = 0) {
  return {"walk", id, revision};
}

inline storage::ClipChange ChangeOfClip(const std::string& clip = "walk") {
  storage::ClipChange change;
  change.clip = clip;
  return change;
}

inline storage::SegmentRecord Get(StoreUnderTest& store, const std::string& id) {
  return Require(store->annotations().GetSegment("d", "walk", id));
}

inline std::string Ids(StoreUnderTest& store, const std::string& clip = "walk") {
  std::string ids;
  for (const auto& segment : Require(store->annotations().ListSegments("d", clip))) {
    ids += segment.id + " ";
  }
  return ids;
}

inline std::string LabelOfWalk(StoreUnderTest& store) {
  return Require(store->GetClip("d", "walk")).label;
}

inline std::string ReasonOf(const absl::Status& status) {
  const auto reason = status.GetPayload(core::kReasonUrl);
  return reason ? std::string(*reason) : "";
}

}  // namespace motiondb::tests
