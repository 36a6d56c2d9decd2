// Databases as messages, and settings from them. Safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "server/engine/live_database.h"
#include "server/engine/marker_schemes.h"
#include "storage/records.h"

namespace motiondb::v1 {
class Database;
class DescribeDatabaseResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// The settings of a database to create, with defaults for those not given. INVALID_ARGUMENT names
// the field, below `database`.
absl::StatusOr<core::BuildSettings> SettingsFrom(const v1::Database& database);
absl::StatusOr<MarkerSetSetting> MarkerSetFrom(const v1::Database& database);

void SetDatabase(const storage::DatabaseRecord& record, const LiveDatabase& live,
                 v1::Database& message);
// `snapshot` may be null.
void SetDescription(const LiveDatabase& live, const Snapshot* snapshot,
                    v1::DescribeDatabaseResponse& message);

}  // namespace motiondb::server
