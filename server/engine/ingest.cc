#include "server/engine/ingest.h"

#include <memory>
#include <mutex>
#include <utility>
#include <variant>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "server/engine/clock.h"
#include "server/engine/file_names.h"
#include "server/engine/representation.h"

namespace motiondb::server {
namespace {

// Label of a clip without a label.
constexpr char kNoLabel[] = "unlabelled";

using SchemePointer = std::shared_ptr<const core::MarkerScheme>;

absl::StatusOr<core::MotionFile> Read(const IngestFile& file) {
  std::optional<core::SourceFile> skeleton;
  if (!file.skeleton_file_name.empty()) {
    skeleton = core::SourceFile{file.skeleton_file_name, file.skeleton_bytes};
  }
  return core::ReadMotionFile(file.format, {file.file_name, file.file_bytes}, skeleton,
                              file.conventions);
}

storage::NewClip MakeClip(const LiveDatabase& database, IngestFile file,
                          const core::MotionFile& source, core::StateSequence states,
                          const std::vector<std::string>& notes) {
  storage::NewClip clip;
  storage::ClipRecord& record = clip.record;
  record.database = database.name();
  record.id = file.clip_id.empty() ? ClipIdFromFileName(file.file_name) : file.clip_id;
  record.label = file.label.empty() ? kNoLabel : std::move(file.label);
  record.subject = std::move(file.subject);
  record.file_name = std::move(file.file_name);
  record.skeleton_file_name = std::move(file.skeleton_file_name);
  record.format = file.format;
  record.frame_count = states.frame_count();
  record.duration_seconds = states.frame_count() / states.frame_rate_hz;
  record.source_frame_rate_hz = FrameRate(source.motion);
  record.leg_length_m = states.leg_length_m;
  record.source_report = ReportOf(source.report, notes);
  record.given = file.conventions;
  record.given_leg_length_m = file.leg_length_m;
  record.create_time_us = record.tried_time_us = NowMicroseconds();
  clip.id_is_fixed = !file.clip_id.empty();
  clip.file_bytes = std::move(file.file_bytes);
  clip.skeleton_bytes = std::move(file.skeleton_bytes);
  clip.audit = std::move(file.audit);
  clip.states = std::move(states);
  if (const auto* joints = std::get_if<core::JointMotion>(&source.motion)) {
    clip.skeleton = *joints->skeleton;
  }
  return clip;
}

// Estimates the byte count that the store will report.
std::int64_t ByteCount(const storage::NewClip& clip) {
  return static_cast<std::int64_t>(clip.file_bytes.size() + clip.skeleton_bytes.size()) +
         static_cast<std::int64_t>(sizeof(float)) * clip.states.states.size();
}

absl::StatusOr<storage::ClipRecord> AddWithinQuota(const DatabaseQuota& quota,
                                                   storage::MotionStore& store,
                                                   LiveDatabase& database,
                                                   const storage::NewClip& clip) {
  const StoredAmount expected = AmountOf(clip.record);
  MOTIONDB_RETURN_IF_ERROR(database.Reserve(expected, quota));
  absl::Cleanup undo = [&] { database.AddStored(-expected); };
  auto added = store.AddClip(clip);
  if (added.ok()) {
    std::move(undo).Cancel();
    database.AddStored({0, 0, added->byte_count - expected.byte_count});
  }
  return added;
}

}  // namespace

std::string ReportOf(const core::SourceReport& report, const std::vector<std::string>& notes) {
  std::string text = core::Describe(report);
  for (const std::string& note : notes) text += "; " + note;
  return text;
}

absl::StatusOr<storage::ClipRecord> IngestClip(
    storage::MotionStore& store, LiveDatabase& database, IngestFile file,
    const EngineOptions& options, const core::ParallelFor& parallel, const WorkOptions& terms,
    const std::function<absl::Status(const storage::ClipRecord&)>& stored) {
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(core::MaxBytesToRead(
      file.format, {file.file_name, file.file_bytes},
      file.skeleton_file_name.empty()
          ? std::nullopt
          : std::optional(core::SourceFile{file.skeleton_file_name, file.skeleton_bytes}))));
  absl::StatusOr<core::MotionFile> source;
  std::uint64_t content_hash = 0;
  // The hash runs byte by byte and takes a third of the time of reading.
  parallel(2, [&](int part) {
    if (part == 0) {
      source = Read(file);
    } else {
      content_hash = ContentHash(file.file_bytes, file.skeleton_bytes);
    }
  });
  if (!source.ok()) return source.status();

  // The first clip of a `source` database determines the markers; other ingests wait for it.
  storage::CancellableMutex::Holder first_clip;
  MOTIONDB_ASSIGN_OR_RETURN(SchemePointer scheme, database.scheme());
  if (scheme == nullptr) {
    MOTIONDB_ASSIGN_OR_RETURN(first_clip, database.first_clip_mutex().Lock(terms.cancelled));
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
                                file.leg_length_m, &notes);
  if (const absl::Status& status = states.status();
      absl::IsInvalidArgument(status) || absl::IsResourceExhausted(status)) {
    return absl::Status(status.code(),
                        fmt::format("{}: {}", file.file_name, std::string(status.message())));
  }
  if (!states.ok()) return states.status();
  if (states->frame_count() < kMinClipFrames) {
    return core::InvalidArgument("{}: expected at least {} frames at {:g} Hz, got {}",
                                 file.file_name, kMinClipFrames, limits.frame_rate_hz,
                                 states->frame_count());
  }

  storage::NewClip clip = MakeClip(database, std::move(file), *source, *std::move(states), notes);
  clip.record.content_hash = content_hash;
  clip.cancelled = terms.cancelled;
  if (brings_scheme) clip.marker_set_text = core::WriteMarkerSetFile(*scheme);

  clip.record.byte_count = ByteCount(clip);
  storage::ClipRecord record;
  MOTIONDB_RETURN_IF_ERROR(database.WithSharedUse(DeletionPolicy::kRefuse, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(record, AddWithinQuota(options.quota, store, database, clip));
    if (brings_scheme) database.set_scheme(scheme);
    return stored(record);
  }));
  return record;
}

}  // namespace motiondb::server
