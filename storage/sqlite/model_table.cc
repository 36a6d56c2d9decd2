#include "storage/sqlite/model_table.h"

#include <limits>
#include <span>
#include <utility>

#include "core/model/extend_model.h"
#include "core/motion/error.h"
#include "storage/blob/model_codec.h"
#include "storage/blob/states_codec.h"
#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/clip_table.h"
#include "storage/sqlite/database_table.h"
#include "storage/sqlite/model_states.h"
#include "storage/sqlite/row_checksum.h"

namespace motiondb::storage {
namespace {

constexpr int kModelsKept = 1000;  // figures of superseded models

BlobOwner ModelOwner(std::int64_t model_key) { return {"model", model_key}; }

// A query for models as ToRecord reads them; `rest` follows the database in the condition.
std::string SelectWhere(std::string_view rest) {
  return fmt::format(
      "SELECT model_key, version, current, create_time_us, build_seconds, frame_count, clip_count, "
      "dimension_count, added_clip_count, added_frame_count, stale_share FROM model "
      "WHERE database_key = ? AND {}",
      rest);
}

absl::StatusOr<ModelRecord> ToRecord(Connection& connection, const std::string& database,
                                     const Statement& row) {
  ModelRecord record;
  record.database = database;
  record.version = row.Integer<std::int32_t>(1);
  record.current = row.Integer(2) != 0;
  record.create_time_us = row.Integer(3);
  record.build_seconds = row.Real(4);
  record.frame_count = row.Integer<std::int32_t>(5);
  record.clip_count = row.Integer<std::int32_t>(6);
  record.dimension_count = row.Integer<std::int32_t>(7);
  record.added_clip_count = row.Integer<std::int32_t>(8);
  record.added_frame_count = row.Integer<std::int32_t>(9);
  record.stale_share = row.Real(10);
  Statement layer = connection.Query(
      "SELECT node_count FROM model_layer WHERE model_key = ? ORDER BY layer", row.Integer(0));
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, layer.Step());
    if (!found) return record;
    record.nodes_per_layer.push_back(layer.Integer<std::int32_t>(0));
  }
}

absl::StatusOr<int> NextVersion(Connection& connection, std::int64_t database_key) {
  Statement row = connection.Query(
      "UPDATE database SET last_model_version = last_model_version + 1 WHERE database_key = ? "
      "RETURNING last_model_version",
      database_key);
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  const int version = row.Integer<int>(0);
  MOTIONDB_RETURN_IF_ERROR(row.Run());
  MOTIONDB_RETURN_IF_ERROR(SetRowChecksum(connection, "database", database_key));
  return version;
}

// Keys of the model's clips from number `first` on.
absl::StatusOr<std::vector<std::int64_t>> FindModelClips(Connection& connection,
                                                         std::int64_t database_key,
                                                         const core::Model& model, int first,
                                                         Deleted deleted) {
  std::vector<std::int64_t> keys;
  for (const core::ModelClip& clip : std::span(model.clips()).subspan(first)) {
    const std::span root_path(model.root_path().row(clip.first_frame).data(),
                              3 * static_cast<std::size_t>(clip.frame_count));
    MOTIONDB_ASSIGN_OR_RETURN(keys.emplace_back(),
                              FindModelClip(connection, database_key, clip, root_path, deleted));
  }
  return keys;
}

absl::Status InsertLayers(Connection& connection, std::int64_t model_key, const core::Tree& tree) {
  for (int layer = 1; layer <= tree.layer_count(); ++layer) {
    MOTIONDB_RETURN_IF_ERROR(
        connection
            .Query("INSERT INTO model_layer (model_key, layer, node_count, row_crc) "
                   "VALUES (?1, ?2, ?3, motiondb_crc(?1, ?2, ?3))",
                   model_key, layer, tree.node_count(layer))
            .Run());
  }
  return absl::OkStatus();
}

// Inserts the figures of a model as those of the current one; returns its key.
absl::StatusOr<std::int64_t> InsertFigures(Connection& connection, std::int64_t database_key,
                                           int version, const core::Model& model,
                                           std::int64_t create_time_us) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("INSERT INTO model (database_key, version, current, create_time_us, "
                 "build_seconds, frame_count, clip_count, dimension_count) "
                 "VALUES (?, ?, 1, ?, ?, ?, ?, ?)",
                 database_key, version, create_time_us, model.build_seconds(), model.frame_count(),
                 model.clips().size(), model.states().cols())
          .Run());
  const std::int64_t model_key = connection.last_insert_key();
  MOTIONDB_RETURN_IF_ERROR(SetRowChecksum(connection, "model", model_key));
  MOTIONDB_RETURN_IF_ERROR(InsertLayers(connection, model_key, model.tree()));
  return model_key;
}

// Deletes figures of models that were superseded long ago, but of builds that models which are kept
// extend.
absl::Status ForgetOldFigures(Connection& connection, std::int64_t database_key, int version) {
  const int last = version - kModelsKept;
  return connection
      .Query(
          "DELETE FROM model WHERE database_key = ? AND current = 0 AND version <= ? AND "
          "model_key NOT IN (SELECT base_key FROM model WHERE database_key = ? AND version > ? AND "
          "base_key IS NOT NULL)",
          database_key, last, database_key, last)
      .Run();
}

// The current model as it is stored.
struct CurrentModel {
  std::int64_t model_key = 0;
  std::int64_t built_key = 0;  // of the build that it is or extends
  int version = 0;
  int clip_count = 0;
  int frame_count = 0;
};

// NOT_FOUND if there is none.
absl::StatusOr<CurrentModel> FindCurrentModel(Connection& connection, const std::string& database,
                                              std::int64_t database_key) {
  Statement row = connection.Query(
      "SELECT model_key, COALESCE(base_key, model_key), version, clip_count, frame_count "
      "FROM model WHERE database_key = ? AND current = 1",
      database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return core::NotFound("database '{}' has no model", database);
  return CurrentModel{row.Integer(0), row.Integer(1), row.Integer<int>(2), row.Integer<int>(3),
                      row.Integer<int>(4)};
}

// Whether the first clips of `model` are those of the current model.
absl::StatusOr<bool> Extends(Connection& connection, const core::Model& model,
                             const CurrentModel& current) {
  const auto& clips = model.clips();
  const auto count = static_cast<std::size_t>(current.clip_count);
  if (clips.size() <= count || clips[count].first_frame != current.frame_count) return false;
  Statement row = connection.Query(
      "SELECT id FROM model_clip JOIN clip USING (clip_key) WHERE model_key = ? ORDER BY position",
      current.built_key);
  for (std::size_t c = 0; c < count; ++c) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found || row.Text(0) != clips[c].id) return false;
  }
  return true;
}

absl::Status InsertClips(Connection& connection, std::int64_t built_key, std::int64_t first,
                         const std::vector<std::int64_t>& clip_keys) {
  for (std::size_t i = 0; i < clip_keys.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(
        connection
            .Query("INSERT INTO model_clip (model_key, position, clip_key, row_crc) "
                   "VALUES (?1, ?2, ?3, motiondb_crc(?1, ?2, ?3))",
                   built_key, first + static_cast<std::int64_t>(i), clip_keys[i])
            .Run());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::int64_t>> SelectModelClips(Connection& connection,
                                                           std::int64_t model_key) {
  Statement row = connection.Query(
      "SELECT clip_key FROM model_clip WHERE model_key = ? ORDER BY position", model_key);
  std::vector<std::int64_t> keys;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return keys;
    keys.push_back(row.Integer(0));
  }
}

// Clips that were added after the build, as they were given to the model.
absl::StatusOr<std::vector<core::BuildInput>> ReadAddedClips(Connection& connection,
                                                             std::span<const std::int64_t> keys) {
  std::vector<core::BuildInput> inputs;
  for (const std::int64_t key : keys) {
    Statement row = connection.Query("SELECT id, label, subject FROM clip WHERE clip_key = ?", key);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return core::DataLoss("an added clip is not there");
    core::BuildInput& input = inputs.emplace_back();
    input.clip_id = row.Text(0);
    input.label = row.Text(1);
    input.subject = row.Text(2);
    const auto decode = [&](ByteSource& source) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(input.states, DecodeStates(source));
      return absl::OkStatus();
    };
    MOTIONDB_RETURN_IF_ERROR(In(fmt::format("clip '{}'", input.clip_id),
                                ReadBlob(connection, ClipOwner(key), BlobKind::kStates, decode)));
  }
  return inputs;
}

absl::StatusOr<core::Model> ReadModelOf(std::span<Connection* const> connections,
                                        const CurrentModel& current,
                                        const core::ParallelFor& parallel) {
  Connection& first = *connections.front();
  MOTIONDB_ASSIGN_OR_RETURN(const auto states,
                            ModelStates::Find(first, current.model_key, current.built_key));
  core::ModelParts parts;
  absl::Status read;
  parallel(static_cast<int>(connections.size()), [&](int i) {
    if (i > 0) return states->ReadSome(*connections[i]).IgnoreError();  // the first reads the rest
    read = ReadBlob(first, ModelOwner(current.built_key), BlobKind::kModel,
                    [&](ByteSource& source) -> absl::Status {
                      MOTIONDB_ASSIGN_OR_RETURN(parts, DecodeModel(source));
                      return absl::OkStatus();
                    });
    if (read.ok()) read = states->ReadSome(first);
  });
  MOTIONDB_RETURN_IF_ERROR(read);
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip_keys, SelectModelClips(first, current.built_key));
  if (std::ssize(clip_keys) != current.clip_count || clip_keys.size() < parts.clips.size()) {
    return core::DataLoss("parts: expected {} clips, got {}", current.clip_count, clip_keys.size());
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      auto inputs, ReadAddedClips(first, std::span(clip_keys).subspan(parts.clips.size())));
  MOTIONDB_RETURN_IF_ERROR(states->MoveInto(parts, parallel));
  auto built = core::Model::Create(std::move(parts), parallel);
  if (!built.ok() || inputs.empty()) return built;
  auto model = core::ExtendModel(*built, std::move(inputs), parallel);
  if (!model.ok()) return core::DataLoss("{}", std::string(model.status().message()));
  return model;
}

absl::Status Supersede(Connection& connection, std::int64_t model_key) {
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE model SET current = 0 WHERE model_key = ?", model_key).Run());
  return SetRowChecksum(connection, "model", model_key);
}

// The current model, if there is one, is current no more; its clips may be purged.
absl::Status Retire(Connection& connection, std::int64_t database_key, Remains remains) {
  for (const char* table : {"model_chunk", "model_clip"}) {
    if (remains == Remains::kLeave && table == std::string_view("model_chunk")) continue;
    MOTIONDB_RETURN_IF_ERROR(
        connection
            .Query(fmt::format("DELETE FROM {} WHERE model_key IN (SELECT COALESCE(base_key, "
                               "model_key) FROM model WHERE database_key = ? AND current = 1)",
                               table),
                   database_key)
            .Run());
  }
  Statement current = connection.Query(
      "SELECT model_key FROM model WHERE database_key = ? AND current = 1", database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, current.Step());
  if (!found) return absl::OkStatus();
  const std::int64_t key = current.Integer(0);
  current.Reset();
  return Supersede(connection, key);
}

}  // namespace

absl::StatusOr<ModelRecord> InsertModel(Connection& connection, const std::string& database,
                                        const core::Model& model, std::int64_t create_time_us,
                                        Remains remains) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip_keys,
                            FindModelClips(connection, database_key, model, 0, Deleted::kToo));
  MOTIONDB_ASSIGN_OR_RETURN(const int version, NextVersion(connection, database_key));
  MOTIONDB_RETURN_IF_ERROR(Retire(connection, database_key, remains));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t model_key,
      InsertFigures(connection, database_key, version, model, create_time_us));
  MOTIONDB_RETURN_IF_ERROR(InsertClips(connection, model_key, 0, clip_keys));
  if (remains == Remains::kFree) {
    MOTIONDB_RETURN_IF_ERROR(PurgeRemovedClips(connection, database_key));
  }
  MOTIONDB_RETURN_IF_ERROR(
      WriteBlob(connection, ModelOwner(model_key), BlobKind::kModel,
                [&](ByteSink& sink) { return EncodeModel(model.parts(), sink); }));
  MOTIONDB_RETURN_IF_ERROR(ForgetOldFigures(connection, database_key, version));
  return SelectModel(connection, database, version);
}

absl::StatusOr<ModelRecord> InsertExtension(Connection& connection, const std::string& database,
                                            const core::Model& model, double stale_share,
                                            std::int64_t create_time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  const auto current = FindCurrentModel(connection, database, database_key);
  if (!current.ok() && !absl::IsNotFound(current.status())) return current.status();
  bool extends = current.ok();
  if (extends) {
    MOTIONDB_ASSIGN_OR_RETURN(extends, Extends(connection, model, *current));
  }
  if (!extends) {
    return core::FailedPrecondition("the model does not extend the current one of database '{}'",
                                    database);
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto clip_keys,
      FindModelClips(connection, database_key, model, current->clip_count, Deleted::kNot));
  MOTIONDB_ASSIGN_OR_RETURN(const int version, NextVersion(connection, database_key));
  MOTIONDB_RETURN_IF_ERROR(Supersede(connection, current->model_key));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t model_key,
      InsertFigures(connection, database_key, version, model, create_time_us));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE model SET base_key = ?, added_clip_count = ?, added_frame_count = ?, "
                 "stale_share = ? WHERE model_key = ?",
                 current->built_key, std::ssize(model.clips()) - model.built_clip_count(),
                 model.frame_count() - model.built_frame_count(), stale_share, model_key)
          .Run());
  MOTIONDB_RETURN_IF_ERROR(SetRowChecksum(connection, "model", model_key));
  MOTIONDB_RETURN_IF_ERROR(
      InsertClips(connection, current->built_key, current->clip_count, clip_keys));
  MOTIONDB_RETURN_IF_ERROR(ForgetOldFigures(connection, database_key, version));
  return SelectModel(connection, database, version);
}

absl::StatusOr<core::Model> SelectCurrentModel(std::span<Connection* const> connections,
                                               const std::string& database,
                                               const core::ParallelFor& parallel) {
  Connection& connection = *connections.front();
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const CurrentModel current,
                            FindCurrentModel(connection, database, database_key));
  auto model = ReadModelOf(connections, current, parallel);
  if (!model.ok()) {
    return In(fmt::format("database '{}', model {}", database, current.version), model.status());
  }
  return model;
}

absl::StatusOr<ModelGap> SelectModelGap(Connection& connection, const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  const auto current = FindCurrentModel(connection, database, database_key);
  if (!current.ok() && !absl::IsNotFound(current.status())) return current.status();
  const std::int64_t built_key = current.ok() ? current->built_key : 0;
  ModelGap gap;
  Statement missing = connection.Query(
      "SELECT id FROM clip WHERE database_key = ? AND deleted = 0 AND clip_key NOT IN "
      "(SELECT clip_key FROM model_clip WHERE model_key = ?) ORDER BY id",
      database_key, built_key);
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, missing.Step());
    if (!found) break;
    gap.missing.emplace_back(missing.Text(0));
  }
  Statement removed = connection.Query(
      "SELECT COUNT(*) FROM model_clip JOIN clip USING (clip_key) WHERE model_key = ? AND "
      "deleted = 1",
      built_key);
  MOTIONDB_RETURN_IF_ERROR(removed.Step().status());
  gap.removed = removed.Integer<int>(0);
  return gap;
}

absl::StatusOr<ModelRecord> SelectModel(Connection& connection, const std::string& database,
                                        int version) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectWhere("version = ?"), database_key, version);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return core::NotFound("database '{}' has no model {}", database, version);
  return ToRecord(connection, database, row);
}

absl::StatusOr<std::vector<ModelRecord>> SelectModels(Connection& connection,
                                                      const std::string& database, int before,
                                                      int limit) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  const std::int64_t below = before > 0 ? before : std::numeric_limits<std::int64_t>::max();
  Statement row = connection.Query(SelectWhere("version < ? ORDER BY version DESC LIMIT ?"),
                                   database_key, below, limit);
  std::vector<ModelRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToRecord(connection, database, row));
  }
}

absl::Status RetireCurrentModel(Connection& connection, const std::string& database,
                                Remains remains) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_RETURN_IF_ERROR(Retire(connection, database_key, remains));
  if (remains == Remains::kLeave) return absl::OkStatus();
  return PurgeRemovedClips(connection, database_key);
}

}  // namespace motiondb::storage
