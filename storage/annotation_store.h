// Interface of the storage of annotations: edits of clips and segments, their history, the changes
// of a database, and full-text search. Thread-safe; codes as in motion_store.h.
//
// Each transaction that changes a database gives it the next revision. Every changed clip, segment
// and model has the revision of its last change, which is its etag. Of deleted clips and segments a
// tombstone is kept, so that Changes finds them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/records.h"

namespace motiondb::storage {

// Id of the segment that the label of an ingest, or ClipChange::label, creates.
inline constexpr char kLabelSegment[] = "label";

// Changes of one transaction. `revision` is the revision of the object that the caller saw; 0: any.

// Sets those values of a clip that are present. `label`: of the segment of track kActionTrack that
// covers the clip; it is created if the track is empty.
struct ClipChange {
  std::string clip;
  std::int64_t revision = 0;
  std::optional<std::string> label;
  std::optional<std::string> subject;
  std::optional<std::string> title;
  std::optional<std::string> description;
  std::optional<std::vector<std::string>> tags;
  std::optional<Fields> fields;                                 // all of them
  std::map<std::string, std::optional<FieldValue>> field = {};  // single ones; none: removes it
};

// Adds a segment. `segment.id` empty: the store chooses it. The segment that a clip's label made
// (kLabelSegment) gives way to one of the same track that does not cover the clip.
struct SegmentCreation {
  SegmentRecord segment;
};

// Sets those values of a segment that are present.
struct SegmentChange {
  std::string clip;
  std::string id;
  std::int64_t revision = 0;
  std::optional<std::string> label;
  std::optional<double> start_seconds;
  std::optional<std::optional<double>> end_seconds;  // inner none: the end of the clip
  std::optional<SegmentSource> source;
  std::optional<double> confidence;
};

struct SegmentDeletion {
  std::string clip;
  std::string id;
  std::int64_t revision = 0;
};

using Change = std::variant<ClipChange, SegmentCreation, SegmentChange, SegmentDeletion>;

// The editable state of a clip: its record, of which only label, subject and annotations count; or
// of a segment.
using EditedState = std::variant<ClipRecord, SegmentRecord>;

struct EditedObject {
  std::optional<EditedState> before;  // none: created
  std::optional<EditedState> after;   // none: deleted
};

struct EditRecord {
  std::string database;
  std::int64_t id = 0;  // the revision that it made
  std::string author;
  std::int64_t time_us = 0;
  std::vector<EditedObject> objects;  // in the order of the changes, each object once
};

// A change of a database since a revision.
struct ClipPut {
  ClipRecord clip;
};
struct SegmentPut {
  SegmentRecord segment;
};
struct ModelPut {
  std::int32_t version = 0;  // 0: the model was removed
};
struct Deleted {
  std::string clip;
  std::string segment;  // empty: the clip itself
};
struct ChangeRecord {
  std::int64_t revision = 0;
  std::variant<ClipPut, SegmentPut, ModelPut, Deleted> change;
};

// A clip that matches a text search.
struct TextMatch {
  std::string clip;
  double score = 0;  // higher is better
};

class AnnotationStore {
 public:
  virtual ~AnnotationStore() = default;

  // Makes the changes in order, in one transaction, and returns the edit. Changes without effect
  // are not in it; without any effect nothing is stored, no audit entry either, and its id is 0. A
  // change of a segment that changes the label of its clip also changes the clip. ABORTED if an
  // object's revision differs from the one before the edit; NOT_FOUND; ALREADY_EXISTS (segment id);
  // FAILED_PRECONDITION with reason SEGMENTS_OVERLAP, or with CLIP_HAS_SEGMENTS if a label is set
  // and the clip has other segments on the track; INVALID_ARGUMENT if a segment does not end after
  // it starts, or ends more than half a frame after its clip. An end within half a frame of the end
  // of the clip is stored as none. The message begins with the index of the change, as in
  // `changes[3]`, if there are several.
  virtual absl::StatusOr<EditRecord> Edit(const std::string& database,
                                          std::span<const Change> changes,
                                          const std::string& author,
                                          const WriteOptions& terms = {}) = 0;
  // Restores the states before an edit, as a new edit. ABORTED, naming the object, if the state of
  // one is not the one after the edit: undo later edits first. FAILED_PRECONDITION with reason
  // SEGMENTS_OVERLAP if a later segment is in the place of a restored one; NOT_FOUND if the edit is
  // unknown or no longer kept.
  virtual absl::StatusOr<EditRecord> UndoEdit(const std::string& database, std::int64_t edit,
                                              const std::string& author,
                                              const WriteOptions& terms = {}) = 0;
  // Returns at most `limit` edits with an id below `before` (0: from the newest), newest first; of
  // one clip and its segments, or of all (`clip` empty). The last 10,000 edits of a database are
  // kept.
  virtual absl::StatusOr<std::vector<EditRecord>> ListEdits(const std::string& database,
                                                            const std::string& clip,
                                                            std::int64_t before, int limit) = 0;

  virtual absl::StatusOr<SegmentRecord> GetSegment(const std::string& database,
                                                   const std::string& clip,
                                                   const std::string& segment) = 0;
  // Returns the segments of a clip, in order of track and start.
  virtual absl::StatusOr<std::vector<SegmentRecord>> ListSegments(const std::string& database,
                                                                  const std::string& clip) = 0;

  // Returns the revision of a database.
  virtual absl::StatusOr<std::int64_t> Revision(const std::string& database) = 0;
  // Returns the changes after a revision, ascending by revision: at least `limit` if there are that
  // many, and all of the last one's transaction. Of one transaction, deletions come first, then
  // clips, segments and the model. A clip that changed after its segments is listed after them. An
  // object that changed several times is listed once, with its
  // last state; a deleted one as Deleted. The segments of a deleted clip are not listed. A clip
  // with the id of a deleted one is listed after the deletion. OUT_OF_RANGE with reason
  // REVISION_TOO_OLD if `after` is not 0 and deletions after it are no longer known (the last
  // 100,000 are kept). One snapshot of the database.
  //
  // `begun`: the revision of the database before the caller began to read from 0 on, if it did: it
  // needs no deletions up to that revision. 0: the caller has the whole state of `after`.
  virtual absl::StatusOr<std::vector<ChangeRecord>> Changes(const std::string& database,
                                                            std::int64_t after, int limit,
                                                            std::int64_t begun = 0) = 0;

  // Returns the clips whose title, description, tags, labels, subject or file name contain all
  // words of a query: `walk*` is a prefix, `"slow walk"` a phrase. Upper and lower case and accents
  // are not distinguished. INVALID_ARGUMENT, with the position, for an invalid query.
  virtual absl::StatusOr<std::vector<TextMatch>> SearchClips(const std::string& database,
                                                             const std::string& query) = 0;
};

}  // namespace motiondb::storage
