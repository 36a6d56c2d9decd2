// The migrations, in order. Stored: never change a migration of a released version.
#include <span>

#include "storage/sqlite/build_lease_migration.h"
#include "storage/sqlite/schema.h"

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

// Clips have annotations; segments replace their labels. Edits, deletions and revisions are kept.
// Clips and segments of former versions get the clip's key as their revision, so that a list of
// changes has pages. Deleted clips keep their segments: a model can still use them. clip_text has
// normalised words (text_query.h) of which each byte is part of a token.
constexpr char kAnnotations[] = R"sql(
ALTER TABLE database ADD COLUMN revision INTEGER NOT NULL DEFAULT 0;
ALTER TABLE database ADD COLUMN removed_revision INTEGER NOT NULL DEFAULT 0;  -- of tombstones
ALTER TABLE model ADD COLUMN revision INTEGER NOT NULL DEFAULT 0;
ALTER TABLE clip ADD COLUMN title TEXT NOT NULL DEFAULT '';
ALTER TABLE clip ADD COLUMN description TEXT NOT NULL DEFAULT '';
ALTER TABLE clip ADD COLUMN annotations BLOB;  -- tags and fields; NULL: none
ALTER TABLE clip ADD COLUMN revision INTEGER NOT NULL DEFAULT 0;
ALTER TABLE clip ADD COLUMN edit_time_us INTEGER NOT NULL DEFAULT 0;

CREATE TABLE segment (
  segment_key INTEGER PRIMARY KEY,
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  clip_key INTEGER NOT NULL REFERENCES clip ON DELETE CASCADE,
  id TEXT NOT NULL CHECK (id <> ''),
  track TEXT NOT NULL,
  label TEXT NOT NULL,
  start_seconds REAL NOT NULL,
  end_seconds REAL,  -- NULL: the end of the clip
  source TEXT NOT NULL CHECK (source IN ('person', 'import', 'suggestion')),
  confidence REAL NOT NULL,
  revision INTEGER NOT NULL,
  author TEXT NOT NULL,
  create_time_us INTEGER NOT NULL,
  update_time_us INTEGER NOT NULL,
  row_crc INTEGER,
  UNIQUE (clip_key, id)
) STRICT;
INSERT INTO segment (database_key, clip_key, id, track, label, start_seconds, source, confidence,
  revision, author, create_time_us, update_time_us)
  SELECT database_key, clip_key, 'label', 'action', label, 0.0, 'import', 1.0, clip_key, '',
    create_time_us, create_time_us FROM clip WHERE label <> '' ORDER BY clip_key;
UPDATE segment SET row_crc = motiondb_crc(segment_key, database_key, clip_key, id, track, label,
  start_seconds, end_seconds, source, confidence, revision, author, create_time_us, update_time_us);
CREATE INDEX segment_by_revision ON segment (database_key, revision);
-- The labels of clips.
CREATE INDEX label_of_clip ON segment (clip_key, label)
  WHERE track = 'action' AND start_seconds = 0.0 AND end_seconds IS NULL;

-- What was deleted from a database. An empty segment: the clip itself.
CREATE TABLE tombstone (
  tombstone_key INTEGER PRIMARY KEY,
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  number INTEGER NOT NULL,  -- rises with each deletion
  revision INTEGER NOT NULL,
  clip TEXT NOT NULL,
  segment TEXT NOT NULL,
  row_crc INTEGER,
  UNIQUE (database_key, clip, segment),
  UNIQUE (database_key, number)
) STRICT;
CREATE INDEX tombstone_by_revision ON tombstone (database_key, revision);

CREATE TABLE edit (
  edit_key INTEGER PRIMARY KEY,
  database_key INTEGER NOT NULL REFERENCES database ON DELETE CASCADE,
  number INTEGER NOT NULL,  -- rises by 1 with each edit
  revision INTEGER NOT NULL,
  author TEXT NOT NULL,
  time_us INTEGER NOT NULL,
  clips TEXT NOT NULL,    -- the ids of its clips, as in '/walk/run/'
  objects BLOB NOT NULL,  -- their states before and after
  row_crc INTEGER,
  UNIQUE (database_key, revision),
  UNIQUE (database_key, number)
) STRICT;

CREATE VIRTUAL TABLE clip_text USING fts5(title, description, tags, labels, subject, file_name,
  tokenize = 'ascii');
INSERT INTO clip_text (rowid, title, description, tags, labels, subject, file_name)
  SELECT clip_key, '', '', '', motiondb_words(label), motiondb_words(subject),
    motiondb_words(file_name) FROM clip WHERE deleted = 0 ORDER BY clip_key;

ALTER TABLE clip DROP COLUMN label;
UPDATE clip SET revision = clip_key, row_crc = motiondb_crc(clip_key, database_key, id, subject,
  file_name, skeleton_file_name, frame_count, duration_seconds, source_frame_rate_hz,
  leg_length_m, skeleton_key, source_report, content_hash, root_path_crc, create_time_us, deleted,
  byte_count, representation_version, tried_version, tried_time_us, derive_error,
  given_metres_per_unit, given_up_axis, given_frame_rate_hz, given_leg_length_m, format,
  given_take, title, description, annotations, clip_key, edit_time_us);
CREATE INDEX clip_by_revision ON clip (database_key, revision) WHERE deleted = 0;
UPDATE database SET revision = 1 + ifnull((SELECT max(clip_key) FROM clip
  WHERE clip.database_key = database.database_key), 0);
UPDATE database SET row_crc = motiondb_crc(database_key, name, frame_rate_hz, min_frames, scaling,
  marker_set, marker_set_text, last_model_version, create_time_us, deleted, glitches, revision,
  removed_revision);
UPDATE model SET revision = (SELECT database.revision FROM database
  WHERE database.database_key = model.database_key) WHERE current = 1;
UPDATE model SET row_crc = motiondb_crc(model_key, database_key, version, current, create_time_us,
  build_seconds, frame_count, clip_count, dimension_count, base_key, added_clip_count,
  added_frame_count, stale_share, staged, revision);
CREATE INDEX model_by_revision ON model (database_key, revision);
)sql";

// The words of the search index are normalised otherwise: Upgrade (store_file.cc) has made the
// index of version 10 again.
constexpr char kUnicodeWords[] = "";

constexpr const char* kMigrations[] = {kFirst,
                                       kExtensions,
                                       kAccess,
                                       kDeletion,
                                       kClipByteCounts,
                                       kRowChecksums,
                                       kStagedModelsAndGlitches,
                                       kRepresentationVersions,
                                       kFormatsAndTakes,
                                       kAnnotations,
                                       kUnicodeWords,
                                       kBuildLeases};

}  // namespace

std::span<const char* const> Migrations() { return kMigrations; }

}  // namespace motiondb::storage
