#include "server/engine/ingest.h"

#include <memory>
#include <mutex>
#include <utility>
#include <variant>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "core/format/marker_set_file.h"
#include "core/format/plausibility.h"
#include "core/motion/error.h"
#include "server/engine/ingest_rules.h"
#include "server/engine/representation.h"
#include "server/engine/source_reader.h"
#include "server/engine/work/clock.h"
#include "storage/clip_segments.h"

namespace motiondb::server {
namespace {

// Label of a clip without a label.
constexpr char kNoLabel[] = "unlabelled";

using SchemePointer = std::shared_ptr<const core::MarkerScheme>;

// Sets what follows from the file and its states.
void Complete(const LiveDatabase& database, const core::MotionFile& source,
              core::StateSequence states, const std::vector<std::string>& notes,
              storage::NewClip& clip) {
  storage::ClipRecord& record = clip.record;
  record.database = database.name();
  clip.database_id = database.id();
  if (!clip.id_is_fixed) record.id = ClipIdFromFileName(record.file_name, record.given.take);
  record.frame_count = states.frame_count();
  record.duration_seconds = states.frame_count() / states.frame_rate_hz;
  record.source_frame_rate_hz = FrameRate(source.motion);
  record.leg_length_m = states.leg_length_m;
  record.source_report = ReportOf(source.report, notes);
  record.create_time_us = NowMicroseconds();
  clip.states = std::move(states);
  if (const auto* joints = std::get_if<core::JointMotion>(&source.motion)) {
    clip.skeleton = *joints->skeleton;
  }
}

// Estimates the byte count that the store will report.
std::int64_t ByteCount(const storage::NewClip& clip) {
  return static_cast<std::int64_t>(clip.file_bytes.size() + clip.skeleton_bytes.size()) +
         static_cast<std::int64_t>(sizeof(float)) * clip.states.states.size();
}

// Adds or replaces a clip. `before`: the clip to replace.
absl::StatusOr<storage::ClipRecord> StoreWithinQuota(
    const DatabaseQuota& quota, storage::MotionStore& store, LiveDatabase& database,
    const std::optional<storage::ClipRecord>& before, const storage::NewClip& clip,
    bool validate_only) {
  const StoredAmount former = before ? AmountOf(*before) : StoredAmount();
  const StoredAmount expected = AmountOf(clip.record) + -former;
  MOTIONDB_RETURN_IF_ERROR(database.Reserve(expected, quota));
  const absl::Cleanup end = [&] { database.EndReservation(expected); };
  if (validate_only) return clip.record;
  auto stored = before ? store.ReplaceClip(*before, clip) : store.AddClip(clip);
  if (stored.ok()) database.CountChange(AmountOf(*stored) + -former, store.annotations());
  return stored;
}

// Returns the stored clip that the request replaces, whose id and labels the new clip gets.
// ALREADY_EXISTS if it is not to be replaced.
absl::StatusOr<std::optional<storage::ClipRecord>> FindReplaced(storage::MotionStore& store,
                                                                IngestRequest& request) {
  storage::NewClip& clip = request.clip;
  std::optional<storage::ClipRecord> before;
  if (request.replace || request.validate_only) {
    auto found = store.FindSameClip(clip);
    if (found.ok()) {
      // The same motion under another id than the given one.
      const bool is_other = clip.id_is_fixed && found->id != clip.record.id;
      if (!request.replace || is_other) return storage::SameClipError(*found, clip);
      before = *std::move(found);
    } else if (!absl::IsNotFound(found.status())) {
      return found.status();
    }
  }
  storage::ClipRecord& record = clip.record;
  if (before) {
    record.id = before->id;
    if (record.label.empty()) record.label = before->label;
    // ReplaceClip does it in its transaction.
    if (request.validate_only) storage::KeepAnnotations(*before, record);
  }
  if (record.label.empty()) record.label = record.given.take;
  if (record.label.empty()) record.label = kNoLabel;
  return before;
}

// Reads the file, and sets its hash and the name of its take.
absl::StatusOr<core::MotionFile> ReadAndHash(IngestRequest& request,
                                             const core::ParallelFor& parallel,
                                             const WorkOptions& terms) {
  storage::NewClip& clip = request.clip;
  storage::ClipRecord& record = clip.record;
  const core::SourceFile file{record.file_name, clip.file_bytes};
  const auto skeleton = SkeletonFile(record, clip.skeleton_bytes);
  absl::StatusOr<core::MotionFile> source;
  const auto read = [&] {
    source = ReadSource(record.format, file, skeleton, record.given, terms);
  };
  const auto hash = [&] {
    record.content_hash = ContentHash(clip.file_bytes, clip.skeleton_bytes, record.given.take);
  };
  if (NeedsImport(request)) {
    // On this thread: the others are for queries.
    if (!request.source) MOTIONDB_RETURN_IF_ERROR(ImportBefore(request, terms));
    source = *std::exchange(request.source, std::nullopt);
    record.given.take = source->take;
    hash();
    return source;
  }
  // The hash runs byte by byte and takes a third of the time of reading.
  parallel(2, [&](int part) { part == 0 ? read() : hash(); });
  return source;
}

}  // namespace

bool NeedsImport(const IngestRequest& request) {
  return core::NeedsImport(request.clip.record.format, request.clip.file_bytes);
}

absl::Status ImportBefore(IngestRequest& request, const WorkOptions& terms) {
  const storage::NewClip& clip = request.clip;
  const storage::ClipRecord& record = clip.record;
  MOTIONDB_ASSIGN_OR_RETURN(
      request.source, ReadSource(record.format, {record.file_name, clip.file_bytes},
                                 SkeletonFile(record, clip.skeleton_bytes), record.given, terms));
  return absl::OkStatus();
}

std::string ReportOf(const core::SourceReport& report, const std::vector<std::string>& notes) {
  std::string text = core::Describe(report);
  for (const std::string& note : notes) text += "; " + note;
  return text;
}

absl::StatusOr<storage::ClipRecord> IngestClip(
    storage::MotionStore& store, LiveDatabase& database, IngestRequest request,
    const EngineOptions& options, const core::ParallelFor& parallel, const WorkOptions& terms,
    const std::function<absl::Status(const storage::ClipRecord&)>& stored) {
  storage::NewClip& clip = request.clip;
  // Before the scheme is read: a reprocessing that is requested after a later change of the scheme
  // includes this clip.
  clip.record.tried_time_us = NowMicroseconds();
  auto source = ReadAndHash(request, parallel, terms);
  if (!source.ok()) return source.status();

  // The first clip of a `source` database determines the markers; other ingests wait for it.
  storage::CancellableMutex::Holder first_clip;
  MOTIONDB_ASSIGN_OR_RETURN(SchemePointer scheme, database.scheme());
  if (scheme == nullptr) {
    MOTIONDB_ASSIGN_OR_RETURN(first_clip, database.scheme_mutex().Lock(terms.cancelled));
    MOTIONDB_ASSIGN_OR_RETURN(scheme, database.scheme());
    if (scheme != nullptr) first_clip.reset();
  }
  const bool brings_scheme = scheme == nullptr;
  if (brings_scheme) {
    MOTIONDB_ASSIGN_OR_RETURN(core::MarkerScheme from_source, core::SourceScheme(source->motion));
    scheme = std::make_shared<const core::MarkerScheme>(std::move(from_source));
  }

  std::vector<std::string> notes;
  const RepresentationLimits limits{database.settings().frame_rate_hz,
                                    options.max_frames,
                                    {AllowedWork::kAllWork, terms.cancelled, terms.reserve}};
  auto states = RepresentWithin(limits, *scheme, source->motion, database.settings().glitches,
                                clip.record.given_leg_length_m, &notes);
  if (const absl::Status& status = states.status();
      absl::IsInvalidArgument(status) || absl::IsResourceExhausted(status)) {
    return absl::Status(
        status.code(), fmt::format("{}: {}", clip.record.file_name, std::string(status.message())));
  }
  if (!states.ok()) return states.status();
  if (states->frame_count() < kMinClipFrames) {
    return core::InvalidArgument("{}: expected at least {} frames at {:g} Hz, got {}",
                                 clip.record.file_name, kMinClipFrames, limits.frame_rate_hz,
                                 states->frame_count());
  }

  if (!request.force) {
    absl::Status plausible = core::CheckBodySize(scheme->set, *states, source->report);
    if (plausible.ok()) plausible = core::CheckPosture(scheme->set, *states, source->report);
    if (!plausible.ok()) {
      absl::Status named =
          core::InvalidArgument("{}: {}", clip.record.file_name, std::string(plausible.message()));
      plausible.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
        named.SetPayload(url, payload);
      });
      return named;
    }
  }

  if (request.points != nullptr) {
    MOTIONDB_ASSIGN_OR_RETURN(*request.points, core::FindSourcePoints(*scheme, source->motion));
  }
  Complete(database, *source, *std::move(states), notes, clip);
  clip.cancelled = terms.cancelled;
  if (brings_scheme) clip.marker_set_text = core::WriteMarkerSetFile(*scheme);

  clip.record.byte_count = ByteCount(clip);
  storage::ClipRecord record;
  MOTIONDB_RETURN_IF_ERROR(database.WithSharedUse(DeletionPolicy::kRefuse, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(const auto before, FindReplaced(store, request));
    MOTIONDB_ASSIGN_OR_RETURN(record, StoreWithinQuota(options.quota, store, database, before, clip,
                                                       request.validate_only));
    if (request.validate_only) return absl::OkStatus();
    if (before) {
      database.ForgetUnreadable(record.id);
      database.SetDeriveError(record.id, "");
    }
    if (brings_scheme) database.set_scheme(scheme);
    return stored(record);
  }));
  return record;
}

}  // namespace motiondb::server
