#include "server/engine/reprocess.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/format/motion_file.h"
#include "core/motion/error.h"
#include "server/engine/compute_model.h"
#include "server/engine/ingest.h"
#include "server/engine/representation.h"
#include "server/engine/source_reader.h"
#include "server/engine/work/clock.h"

namespace motiondb::server {
namespace {

using storage::ClipRecord;
using storage::DerivedClip;

// Limits of one transaction of the store, about 10 ms; a larger clip has its own transaction.
constexpr std::size_t kMaxClipsTogether = 256;
constexpr std::int64_t kMaxBytesTogether = 4 << 20;

template <typename Matrix>
bool SameBytes(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(),
                     sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(a.size())) == 0;
}

bool SameStates(const core::StateSequence& a, const core::StateSequence& b) {
  return a.frame_rate_hz == b.frame_rate_hz && a.leg_length_m == b.leg_length_m &&
         a.glitches == b.glitches && SameBytes(a.states, b.states) &&
         SameBytes(a.root_path, b.root_path);
}

DerivedClip MakeFailed(const ClipRecord& clip, const absl::Status& why) {
  DerivedClip derived{.record = clip, .states = std::nullopt};
  derived.record.tried_version = core::kRepresentationVersion;
  derived.record.tried_time_us = NowMicroseconds();
  derived.record.derive_error = std::string(why.message());
  return derived;
}

// Returns the number of clips, from the first on, that are derived and stored together.
std::size_t CountTogether(std::span<const ClipRecord> clips) {
  std::int64_t bytes = 0;
  std::size_t count = 0;
  while (count < std::min(clips.size(), kMaxClipsTogether)) {
    bytes += clips[count].byte_count;
    if (count > 0 && bytes > kMaxBytesTogether) break;
    ++count;
  }
  return count;
}

class Reprocessor {
 public:
  Reprocessor(storage::MotionStore& store, LiveDatabase& database, const core::MarkerScheme& scheme,
              const core::ParallelFor& parallel, std::int64_t fence, const core::Cancelled& stopped)
      : store_(store),
        database_(database),
        scheme_(scheme),
        parallel_(parallel),
        fence_(fence),
        stopped_(stopped) {}

  const Reprocessed& done() const { return done_; }

  // Derives and stores clips.
  absl::Status Run(std::span<const ClipRecord> clips) {
    std::vector<absl::StatusOr<DerivedClip>> derived(clips.size());
    parallel_(static_cast<int>(clips.size()), [&](int i) { derived[i] = Derive(clips[i]); });
    std::vector<DerivedClip> to_store;
    for (std::size_t i = 0; i < clips.size(); ++i) {
      if (derived[i].ok()) {
        to_store.push_back(*std::move(derived[i]));
      } else if (!absl::IsNotFound(derived[i].status())) {  // deleted meanwhile
        return derived[i].status();
      }
    }
    const absl::Status stored = Store(clips, to_store);
    if (!absl::IsDataLoss(stored)) return stored;
    // One of the clips cannot be replaced: store them one by one.
    for (DerivedClip& single : to_store) {
      absl::Status alone = Store(clips, std::span(&single, 1));
      if (absl::IsDataLoss(alone)) {
        const auto clip = std::ranges::find(clips, single.record.id, &ClipRecord::id);
        single = MakeFailed(*clip, alone);
        alone = Store(clips, std::span(&single, 1));
      }
      MOTIONDB_RETURN_IF_ERROR(alone);
    }
    return absl::OkStatus();
  }

 private:
  // Returns errors of the store, or CANCELLED. Errors of the clip are in the result.
  absl::StatusOr<DerivedClip> Derive(const ClipRecord& clip) {
    if (stopped_()) return absl::CancelledError("stopped");
    const auto source = store_.ReadClipSource(clip.database, clip.id);
    if (absl::IsDataLoss(source.status())) return MakeFailed(clip, source.status());
    if (!source.ok()) return source.status();
    const auto file = ReadSource(clip.format, {clip.file_name, source->file_bytes},
                                 SkeletonFile(clip, source->skeleton_bytes), clip.given,
                                 {AllowedWork::kAllWork, stopped_});
    // Others fail the clip, so that a missing motiondb-import does not stop the rest.
    if (absl::IsUnavailable(file.status()) || absl::IsCancelled(file.status())) {
      return file.status();
    }
    if (!file.ok()) return MakeFailed(clip, file.status());
    std::vector<std::string> notes;
    auto states = Represent(file->motion, clip.given_leg_length_m, notes);
    if (absl::IsCancelled(states.status())) return states.status();
    if (!states.ok()) return MakeFailed(clip, states.status());

    DerivedClip derived{.record = clip, .states = std::nullopt};
    ClipRecord& record = derived.record;
    record.representation_version = record.tried_version = core::kRepresentationVersion;
    record.tried_time_us = NowMicroseconds();
    record.derive_error.clear();
    record.frame_count = states->frame_count();
    record.duration_seconds = states->frame_count() / states->frame_rate_hz;
    record.leg_length_m = states->leg_length_m;
    record.source_report = ReportOf(file->report, notes);
    // If the states are unchanged, a model with the clip stays valid.
    const auto former = store_.ReadClipStates(clip.database, clip.id);
    if (!former.ok() && !absl::IsDataLoss(former.status())) return former.status();
    if (!former.ok() || !SameStates(*former, *states)) derived.states = *std::move(states);
    return derived;
  }

  absl::StatusOr<core::StateSequence> Represent(const core::Motion& motion,
                                                std::optional<double> leg_length_m,
                                                std::vector<std::string>& notes) const {
    auto states = Represent(motion, database_.settings().glitches, leg_length_m, notes);
    if (!absl::IsInvalidArgument(states.status())) return states;
    // Glitches are no reason to lose a clip that was acknowledged.
    notes.clear();
    auto kept = Represent(motion, core::GlitchPolicy::kKeep, leg_length_m, notes);
    if (!kept.ok() || kept->glitches.empty()) return states;
    notes.push_back(fmt::format("kept because it was stored before glitch detection: {}",
                                std::string(states.status().message())));
    return kept;
  }

  absl::StatusOr<core::StateSequence> Represent(const core::Motion& motion,
                                                core::GlitchPolicy policy,
                                                std::optional<double> leg_length_m,
                                                std::vector<std::string>& notes) const {
    // No frame limit: the clip is already stored.
    const RepresentationLimits limits{database_.settings().frame_rate_hz,
                                      std::numeric_limits<int>::max(),
                                      {AllowedWork::kAllWork, stopped_}};
    auto states = RepresentWithin(limits, scheme_, motion, policy, leg_length_m, &notes);
    if (states.ok() && states->frame_count() < kMinClipFrames) {
      return core::InvalidArgument("expected at least {} frames at the database's rate, got fewer",
                                   kMinClipFrames);
    }
    return states;
  }

  // `listed`: contains the former records of `clips`.
  absl::Status Store(std::span<const ClipRecord> listed, std::span<const DerivedClip> clips) {
    return database_.WithSharedUse(DeletionPolicy::kAwait, [&]() -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const auto stored,
                                store_.PutDerived(database_.name(), clips, fence_));
      StoredAmount change;
      for (const ClipRecord& clip : stored) {
        const auto former = std::ranges::find(listed, clip.id, &ClipRecord::id);
        const auto derived = std::ranges::find(
            clips, clip.id,
            [](const DerivedClip& single) -> const auto& { return single.record.id; });
        const bool is_changed = derived->states.has_value();
        if (is_changed) change = change + AmountOf(clip) + -AmountOf(*former);
        Note(clip, is_changed);
      }
      database_.CountChange(change, store_.annotations());
      return absl::OkStatus();
    });
  }

  void Note(const ClipRecord& clip, bool is_changed) {
    ++done_.clips;
    done_.changed += is_changed;
    if (is_changed) database_.ForgetUnreadable(clip.id);
    database_.SetDeriveError(clip.id, clip.derive_error);
    if (clip.derive_error.empty()) return;
    ++done_.failed;
    spdlog::warn("database '{}': clip '{}' could not be derived again: {}", clip.database, clip.id,
                 clip.derive_error);
  }

  storage::MotionStore& store_;
  LiveDatabase& database_;
  const core::MarkerScheme& scheme_;
  const core::ParallelFor& parallel_;
  const std::int64_t fence_;
  const core::Cancelled& stopped_;
  Reprocessed done_;
};

}  // namespace

absl::StatusOr<Reprocessed> Reprocess(storage::MotionStore& store, LiveDatabase& database,
                                      const core::ParallelFor& parallel, std::int64_t fence,
                                      std::int64_t asked_time_us,
                                      const core::BuildProgress& progress,
                                      const core::Cancelled& stopped) {
  MOTIONDB_ASSIGN_OR_RETURN(auto clips, AllClips(store, database.name()));
  MOTIONDB_RETURN_IF_ERROR(CheckNoneIsNewer(clips));
  std::erase_if(clips, [&](const ClipRecord& clip) {
    return clip.tried_version >= core::kRepresentationVersion &&
           clip.tried_time_us >= asked_time_us;
  });
  if (clips.empty()) return Reprocessed{};
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  if (scheme == nullptr) return UnknownMarkers(store, database.name());
  spdlog::info("database '{}': deriving {} clips again", database.name(), clips.size());
  Reprocessor reprocessor(store, database, *scheme, parallel, fence, stopped);
  for (std::size_t first = 0; first < clips.size();) {
    const double share = static_cast<double>(first) / static_cast<double>(clips.size());
    if (!progress(share, fmt::format("deriving clips again, {} of {}", first, clips.size()))) {
      return absl::CancelledError("stopped");
    }
    const auto rest = std::span(clips).subspan(first);
    const std::size_t count = CountTogether(rest);
    MOTIONDB_RETURN_IF_ERROR(reprocessor.Run(rest.first(count)));
    first += count;
  }
  const Reprocessed& done = reprocessor.done();
  spdlog::info("database '{}': clips derived again: {}, changed: {}, failed: {}", database.name(),
               done.clips, done.changed, done.failed);
  return done;
}

}  // namespace motiondb::server
