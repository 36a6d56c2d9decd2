// Derives the states of stored clips again from the files that came in, as if they were ingested by
// the present version, each with what its ingest was given.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/motion/cancellation.h"
#include "core/tree/parallel.h"
#include "server/engine/live_database.h"
#include "storage/motion_store.h"

namespace motiondb::server {

struct Reprocessed {
  int clips = 0;    // that were tried; deleted ones are not counted
  int changed = 0;  // that have other states now
  int failed = 0;   // that could not be derived
};

// Derives again the clips that the present representation (core::kRepresentationVersion) has not
// tried, and those that were last tried before `asked_time_us`. Which these are is stored with the
// clips: after a call that did not end, also because the process did, the next one does the rest.
// The states that the current model was built from stay beside the new ones until another is
// stored.
//
// No clip is lost. One with glitches that the database's setting refuses is derived as by `keep`,
// and its report says so. One that cannot be derived, because its file is damaged or a reader
// refuses it now, keeps the states that it has, with the reason (LiveDatabase::NoteUnderived);
// those of another version are in no new model, and are tried again when that is asked for, or by
// the next version.
//
// `progress` is asked before each few clips, `stopped` often: CANCELLED. NOT_FOUND (the database
// was deleted), and the codes of the store. REQUIRES: called from a build of ModelLifecycle, which
// runs one at a time and beside no purge.
absl::StatusOr<Reprocessed> Reprocess(storage::MotionStore& store, LiveDatabase& database,
                                      const core::ParallelFor& parallel, std::int64_t asked_time_us,
                                      const core::BuildProgress& progress,
                                      const core::Cancelled& stopped);

}  // namespace motiondb::server
