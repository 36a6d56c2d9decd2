#include "storage/sqlite/schema.h"

#include <functional>
#include <map>
#include <string>

#include "core/motion/error.h"
#include "storage/sqlite/transaction.h"

namespace motiondb::storage {
namespace {

constexpr char kFirst[] = R"sql(
CREATE TABLE database (
  database_key INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE CHECK (name <> ''),
  frame_rate_hz REAL NOT NULL CHECK (frame_rate_hz > 0),
  min_frames INTEGER NOT NULL CHECK (min_frames BETWEEN 1 AND 0x7fffffff),
  scaling TEXT NOT NULL CHECK (scaling IN ('none', 'kind', 'dimension')),
  marker_set TEXT NOT NULL,
  marker_set_text TEXT NOT NULL,  -- a marker-set file; empty until a clip brings one
  last_model_version INTEGER NOT NULL DEFAULT 0
    CHECK (last_model_version BETWEEN 0 AND 0x7fffffff),
  create_time_us INTEGER NOT NULL
) STRICT;

CREATE TABLE skeleton (
  skeleton_key INTEGER PRIMARY KEY,
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  id TEXT NOT NULL CHECK (id <> ''),
  encoded_crc INTEGER NOT NULL,  -- of the bytes in its chunks; finds one that is alike
  UNIQUE (database_key, id)
) STRICT;

CREATE TABLE skeleton_chunk (
  chunk_key INTEGER PRIMARY KEY,
  skeleton_key INTEGER NOT NULL REFERENCES skeleton ON DELETE CASCADE,
  kind INTEGER NOT NULL,
  position INTEGER NOT NULL,
  chunk BLOB NOT NULL,
  UNIQUE (skeleton_key, kind, position)
) STRICT;

-- A deleted clip stays, with its states alone, while the current model needs it.
CREATE TABLE clip (
  clip_key INTEGER PRIMARY KEY,
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  id TEXT NOT NULL CHECK (id <> ''),
  label TEXT NOT NULL,
  subject TEXT NOT NULL,
  file_name TEXT NOT NULL,
  skeleton_file_name TEXT NOT NULL,
  format TEXT NOT NULL CHECK (format IN ('bvh', 'amc', 'trc', 'c3d')),
  frame_count INTEGER NOT NULL CHECK (frame_count BETWEEN 0 AND 0x7fffffff),
  duration_seconds REAL NOT NULL,
  source_frame_rate_hz REAL NOT NULL,
  leg_length_m REAL NOT NULL,
  skeleton_key INTEGER REFERENCES skeleton,
  source_report TEXT NOT NULL,
  content_hash INTEGER NOT NULL,    -- 64 bits, unsigned
  root_path_crc INTEGER NOT NULL,   -- tells whether a model was built from this clip
  create_time_us INTEGER NOT NULL,
  deleted INTEGER NOT NULL DEFAULT 0 CHECK (deleted IN (0, 1))
) STRICT;
CREATE UNIQUE INDEX clip_by_id ON clip (database_key, id) WHERE deleted = 0;
CREATE UNIQUE INDEX clip_by_content ON clip (database_key, content_hash) WHERE deleted = 0;
CREATE INDEX clip_by_skeleton ON clip (skeleton_key);

CREATE TABLE clip_chunk (
  chunk_key INTEGER PRIMARY KEY,
  clip_key INTEGER NOT NULL REFERENCES clip ON DELETE CASCADE,
  kind INTEGER NOT NULL,
  position INTEGER NOT NULL,
  chunk BLOB NOT NULL,
  UNIQUE (clip_key, kind, position)
) STRICT;

CREATE TABLE model (
  model_key INTEGER PRIMARY KEY,
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  version INTEGER NOT NULL CHECK (version BETWEEN 1 AND 0x7fffffff),
  current INTEGER NOT NULL CHECK (current IN (0, 1)),
  create_time_us INTEGER NOT NULL,
  build_seconds REAL NOT NULL,
  frame_count INTEGER NOT NULL,
  clip_count INTEGER NOT NULL,
  dimension_count INTEGER NOT NULL,
  UNIQUE (database_key, version)
) STRICT;
CREATE UNIQUE INDEX current_model ON model (database_key) WHERE current = 1;

CREATE TABLE model_layer (
  model_key INTEGER NOT NULL REFERENCES model ON DELETE CASCADE,
  layer INTEGER NOT NULL,
  node_count INTEGER NOT NULL,
  PRIMARY KEY (model_key, layer)
) STRICT, WITHOUT ROWID;

-- The clips of a current model, in the order of its frames.
CREATE TABLE model_clip (
  model_key INTEGER NOT NULL REFERENCES model ON DELETE CASCADE,
  position INTEGER NOT NULL,
  clip_key INTEGER NOT NULL REFERENCES clip,
  PRIMARY KEY (model_key, position)
) STRICT, WITHOUT ROWID;
CREATE INDEX model_clip_by_clip ON model_clip (clip_key);

CREATE TABLE model_chunk (
  chunk_key INTEGER PRIMARY KEY,
  model_key INTEGER NOT NULL REFERENCES model ON DELETE CASCADE,
  kind INTEGER NOT NULL,
  position INTEGER NOT NULL,
  chunk BLOB NOT NULL,
  UNIQUE (model_key, kind, position)
) STRICT;

CREATE TABLE operation (
  sequence INTEGER PRIMARY KEY AUTOINCREMENT,  -- rises with each operation created
  id TEXT NOT NULL UNIQUE CHECK (id <> ''),
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  state TEXT NOT NULL
    CHECK (state IN ('pending', 'running', 'succeeded', 'failed', 'cancelled')),
  progress REAL NOT NULL,
  stage TEXT NOT NULL,
  model_version INTEGER NOT NULL,
  error_code INTEGER NOT NULL,
  error_message TEXT NOT NULL,
  create_time_us INTEGER NOT NULL,
  update_time_us INTEGER NOT NULL
) STRICT;
CREATE INDEX operation_by_database ON operation (database_key, sequence);
)sql";

// A model may extend a build by clips. It then uses the chunks and clips of the build, under the
// build's key; its added clips follow those of the build.
constexpr char kExtensions[] = R"sql(
ALTER TABLE model ADD COLUMN base_key INTEGER REFERENCES model;  -- NULL: it was built
ALTER TABLE model ADD COLUMN added_clip_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE model ADD COLUMN added_frame_count INTEGER NOT NULL DEFAULT 0;
ALTER TABLE model ADD COLUMN stale_share REAL NOT NULL DEFAULT 0;
)sql";

// Tokens and the audit log. They contain names instead of keys of databases: a token may be created
// before its database, and an audit entry outlives the changed object.
constexpr char kAccess[] = R"sql(
CREATE TABLE token (
  sequence INTEGER PRIMARY KEY AUTOINCREMENT,  -- rises with each token made
  id TEXT NOT NULL UNIQUE CHECK (id <> ''),
  role TEXT NOT NULL CHECK (role IN ('reader', 'ingester', 'admin')),
  database TEXT NOT NULL,         -- the one it is good for; empty: all
  description TEXT NOT NULL,
  salt BLOB NOT NULL,
  secret_hash BLOB NOT NULL,
  create_time_us INTEGER NOT NULL,
  expire_time_us INTEGER NOT NULL,  -- 0: never
  revoke_time_us INTEGER NOT NULL   -- 0: it is good
) STRICT;

CREATE TABLE audit (
  sequence INTEGER PRIMARY KEY AUTOINCREMENT,
  time_us INTEGER NOT NULL,
  principal TEXT NOT NULL,
  peer TEXT NOT NULL,
  method TEXT NOT NULL,
  resource TEXT NOT NULL,
  code INTEGER NOT NULL,
  request_id TEXT NOT NULL
) STRICT;
)sql";

// A deleted database stays under a unique name until its content is freed.
constexpr char kDeletion[] = R"sql(
ALTER TABLE database ADD COLUMN deleted INTEGER NOT NULL DEFAULT 0 CHECK (deleted IN (0, 1));
)sql";

// The size of a clip's blobs is a column of the clip. Listing clips then reads no page of chunks,
// and a corrupt page of chunks does not affect the list.
constexpr char kClipByteCounts[] = R"sql(
ALTER TABLE clip ADD COLUMN byte_count INTEGER;  -- NULL: a former version's, not counted yet
)sql";

// Each row has a checksum (row_checksum.h), to detect changes that SQLite did not make.
constexpr char kRowChecksums[] = R"sql(
ALTER TABLE database ADD COLUMN row_crc INTEGER;
ALTER TABLE skeleton ADD COLUMN row_crc INTEGER;
ALTER TABLE clip ADD COLUMN row_crc INTEGER;
ALTER TABLE model ADD COLUMN row_crc INTEGER;
ALTER TABLE model_layer ADD COLUMN row_crc INTEGER;
ALTER TABLE model_clip ADD COLUMN row_crc INTEGER;
ALTER TABLE operation ADD COLUMN row_crc INTEGER;
ALTER TABLE token ADD COLUMN row_crc INTEGER;
ALTER TABLE audit ADD COLUMN row_crc INTEGER;
UPDATE database SET row_crc = motiondb_crc(database_key, name, frame_rate_hz, min_frames, scaling,
  marker_set, marker_set_text, last_model_version, create_time_us, deleted);
UPDATE skeleton SET row_crc = motiondb_crc(skeleton_key, database_key, id, encoded_crc);
UPDATE clip SET row_crc = motiondb_crc(clip_key, database_key, id, label, subject, file_name,
  skeleton_file_name, format, frame_count, duration_seconds, source_frame_rate_hz, leg_length_m,
  skeleton_key, source_report, content_hash, root_path_crc, create_time_us, deleted, byte_count);
UPDATE model SET row_crc = motiondb_crc(model_key, database_key, version, current, create_time_us,
  build_seconds, frame_count, clip_count, dimension_count, base_key, added_clip_count,
  added_frame_count, stale_share);
UPDATE model_layer SET row_crc = motiondb_crc(model_key, layer, node_count);
UPDATE model_clip SET row_crc = motiondb_crc(model_key, position, clip_key);
UPDATE operation SET row_crc = motiondb_crc(sequence, id, database_key, state, progress, stage,
  model_version, error_code, error_message, create_time_us, update_time_us);
UPDATE token SET row_crc = motiondb_crc(sequence, id, role, database, description, salt,
  secret_hash, create_time_us, expire_time_us, revoke_time_us);
UPDATE audit SET row_crc = motiondb_crc(sequence, time_us, principal, peer, method, resource, code,
  request_id);
)sql";

// A model is stored in several transactions; until the last one it is staged. Searches in growing
// tables have an index: deleted clips of a model, deleted databases, equal skeletons, and
// references to a deleted row. A database has a setting for glitches.
constexpr char kStagedModelsAndGlitches[] = R"sql(
ALTER TABLE model ADD COLUMN staged INTEGER NOT NULL DEFAULT 0 CHECK (staged IN (0, 1));
UPDATE model SET row_crc = motiondb_crc(model_key, database_key, version, current, create_time_us,
  build_seconds, frame_count, clip_count, dimension_count, base_key, added_clip_count,
  added_frame_count, stale_share, staged);
CREATE INDEX clip_of_database ON clip (database_key, deleted, id);
CREATE INDEX deleted_database ON database (database_key) WHERE deleted = 1;
CREATE INDEX skeleton_by_content ON skeleton (database_key, encoded_crc);
CREATE INDEX model_by_base ON model (base_key);  -- deleting a model looks for those that extend it
ALTER TABLE database ADD COLUMN glitches TEXT NOT NULL DEFAULT 'repair'
  CHECK (glitches IN ('repair', 'reject', 'drop', 'keep'));
UPDATE database SET row_crc = motiondb_crc(database_key, name, frame_rate_hz, min_frames, scaling,
  marker_set, marker_set_text, last_model_version, create_time_us, deleted, glitches);
)sql";

// Clips have the version of the representation of their states and the conventions to derive them
// again. For clips of former versions these come from the source report (unit and up axis if given)
// and from the record (frame rate and leg length, given or not).
constexpr char kRepresentationVersions[] = R"sql(
ALTER TABLE clip ADD COLUMN representation_version INTEGER NOT NULL DEFAULT 1;
ALTER TABLE clip ADD COLUMN tried_version INTEGER NOT NULL DEFAULT 1;
ALTER TABLE clip ADD COLUMN tried_time_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE clip ADD COLUMN derive_error TEXT NOT NULL DEFAULT '';  -- of the last try; '': none
ALTER TABLE clip ADD COLUMN given_metres_per_unit REAL;  -- NULL, here and below: not given
ALTER TABLE clip ADD COLUMN given_up_axis TEXT
  CHECK (given_up_axis IN ('x', 'y', 'z', '-x', '-y', '-z'));
ALTER TABLE clip ADD COLUMN given_frame_rate_hz REAL;
ALTER TABLE clip ADD COLUMN given_leg_length_m REAL;
UPDATE clip SET
  given_metres_per_unit = CASE WHEN source_report GLOB 'unit * m (given), *'
    THEN CAST(substr(source_report, 6) AS REAL) END,
  given_up_axis = CASE
    WHEN substr(source_report, instr(source_report, '), ') + 3) GLOB '[xyz] up (given)*'
    THEN substr(source_report, instr(source_report, '), ') + 3, 1)
    WHEN substr(source_report, instr(source_report, '), ') + 3) GLOB '-[xyz] up (given)*'
    THEN substr(source_report, instr(source_report, '), ') + 3, 2) END,
  given_frame_rate_hz = CASE WHEN source_report NOT LIKE '% Hz assumed (the file states none)%'
    THEN source_frame_rate_hz END,
  given_leg_length_m = leg_length_m;
UPDATE clip SET row_crc = motiondb_crc(clip_key, database_key, id, label, subject, file_name,
  skeleton_file_name, format, frame_count, duration_seconds, source_frame_rate_hz, leg_length_m,
  skeleton_key, source_report, content_hash, root_path_crc, create_time_us, deleted, byte_count,
  representation_version, tried_version, tried_time_us, derive_error, given_metres_per_unit,
  given_up_axis, given_frame_rate_hz, given_leg_length_m);
ALTER TABLE operation ADD COLUMN kind TEXT NOT NULL DEFAULT 'rebuild'
  CHECK (kind IN ('rebuild', 'reprocess'));
UPDATE operation SET row_crc = motiondb_crc(sequence, id, database_key, state, progress, stage,
  model_version, error_code, error_message, create_time_us, update_time_us, kind);
)sql";

// The name of a format has no CHECK, so that a new format needs no migration; only a new column can
// lose it. A clip may be one take of a file with several.
constexpr char kFormatsAndTakes[] = R"sql(
ALTER TABLE clip RENAME COLUMN format TO former_format;
ALTER TABLE clip ADD COLUMN format TEXT NOT NULL DEFAULT '';
ALTER TABLE clip ADD COLUMN given_take TEXT NOT NULL DEFAULT '';  -- '': the only one
UPDATE clip SET format = former_format;
ALTER TABLE clip DROP COLUMN former_format;
UPDATE clip SET row_crc = motiondb_crc(clip_key, database_key, id, label, subject, file_name,
  skeleton_file_name, frame_count, duration_seconds, source_frame_rate_hz, leg_length_m,
  skeleton_key, source_report, content_hash, root_path_crc, create_time_us, deleted, byte_count,
  representation_version, tried_version, tried_time_us, derive_error, given_metres_per_unit,
  given_up_axis, given_frame_rate_hz, given_leg_length_m, format, given_take);
)sql";

constexpr const char* kMigrations[] = {kFirst,
                                       kExtensions,
                                       kAccess,
                                       kDeletion,
                                       kClipByteCounts,
                                       kRowChecksums,
                                       kStagedModelsAndGlitches,
                                       kRepresentationVersions,
                                       kFormatsAndTakes};

// SQL definition of each table, index, trigger and view by kind and name, without the tables that
// ANALYZE creates. Descending order of kind: tables come before their indices.
using SchemaObjects = std::map<std::string, std::string, std::greater<>>;
absl::StatusOr<SchemaObjects> Definitions(Connection& connection) {
  SchemaObjects definitions;
  Statement object = connection.Query(
      "SELECT type, name, tbl_name, ifnull(sql, '') FROM sqlite_schema "
      "WHERE type <> 'table' OR name NOT IN ('sqlite_stat1', 'sqlite_stat4')");
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool row, object.Step());
    if (!row) return definitions;
    definitions[fmt::format("{} '{}'", object.Text(0), object.Text(1))] =
        fmt::format("{}: {}", object.Text(2), object.Text(3));
  }
}

}  // namespace

std::span<const char* const> Migrations() { return kMigrations; }

absl::Status Migrate(Connection& connection, std::span<const char* const> migrations) {
  const auto latest = static_cast<std::int64_t>(migrations.size());
  MOTIONDB_ASSIGN_OR_RETURN(std::int64_t version, connection.QueryInteger("PRAGMA user_version"));
  if (version < 0 || version > latest) {
    return core::FailedPrecondition(
        "the store is of version {}, from a newer motiondb; this one supports versions up to {}",
        version, latest);
  }
  for (; version < latest; ++version) {
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                              Transaction::Begin(connection, Transaction::Kind::kWrite));
    MOTIONDB_RETURN_IF_ERROR(connection.Execute(migrations[version]));
    MOTIONDB_RETURN_IF_ERROR(
        connection.Execute(fmt::format("PRAGMA user_version = {}", version + 1)));
    MOTIONDB_RETURN_IF_ERROR(transaction.Commit());
  }
  return absl::OkStatus();
}

absl::Status CheckSchema(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto definitions, Definitions(connection));
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto fresh,
      Connection::Open(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
  MOTIONDB_RETURN_IF_ERROR(Migrate(*fresh, kMigrations));
  MOTIONDB_ASSIGN_OR_RETURN(const auto expected, Definitions(*fresh));
  for (const auto& [object, definition] : expected) {
    const auto found = definitions.find(object);
    if (found == definitions.end()) return core::DataLoss("the {} is missing", object);
    if (found->second != definition) return core::DataLoss("the {} was changed", object);
  }
  for (const auto& [object, definition] : definitions) {
    if (!expected.contains(object)) return core::DataLoss("unexpected {}", object);
  }
  return absl::OkStatus();
}

}  // namespace motiondb::storage
