// Derives the states of stored clips again from their source files, with the parameters of their
// ingest, as if they were ingested by the current version.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/motion/execution.h"
#include "server/engine/live_database.h"
#include "storage/motion_store.h"

namespace motiondb::server {

struct Reprocessed {
  int clips = 0;    // tried; without deleted clips
  int changed = 0;  // with different states now
  int failed = 0;   // could not be derived
};

// Derives again all clips that the current representation (core::kRepresentationVersion) has not
// tried, or that were last tried before `asked_time_us`. The store keeps which clips were tried, so
// the next call completes a call that was interrupted, also by a crash. The states of the current
// model are kept beside the new ones until another model is stored.
//
// No clip is lost. A clip with glitches that the database's setting refuses is derived with the
// setting `keep`, and its report notes that. A clip that cannot be derived, because its file is
// corrupt or its reader refuses it now, keeps its states and the reason
// (LiveDatabase::SetDeriveError). States of another version are in no new model. They are tried
// again on request, or by the next version.
//
// `fence`: of the build lease; 0: the store is not shared. ABORTED if another server has the lease.
// Calls `progress` before each group of clips and polls `stopped` often: CANCELLED. NOT_FOUND (the
// database was deleted), NewerFormat, and the codes of the store. REQUIRES: called from a build of
// ModelLifecycle, which runs one at a time and never during a purge.
absl::StatusOr<Reprocessed> Reprocess(storage::MotionStore& store, LiveDatabase& database,
                                      const core::ParallelFor& parallel, std::int64_t fence,
                                      std::int64_t asked_time_us,
                                      const core::BuildProgress& progress,
                                      const core::Cancelled& stopped);

}  // namespace motiondb::server
