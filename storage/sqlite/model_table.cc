#include "storage/sqlite/model_table.h"

#include <limits>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/model_codec.h"
#include "storage/blob/states_codec.h"
#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/clip_table.h"
#include "storage/sqlite/database_table.h"

namespace motiondb::storage {
namespace {

BlobOwner ModelOwner(std::int64_t model_key) { return {"model", model_key}; }

// A query for models as ToRecord reads them; `rest` follows the database in the condition.
std::string SelectWhere(std::string_view rest) {
  return fmt::format(
      "SELECT model_key, version, current, create_time_us, build_seconds, frame_count, clip_count, "
      "dimension_count FROM model WHERE database_key = ? AND {}",
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
  return version;
}

absl::StatusOr<std::vector<std::int64_t>> FindModelClips(Connection& connection,
                                                         std::int64_t database_key,
                                                         const core::Model& model) {
  std::vector<std::int64_t> keys;
  for (const core::ModelClip& clip : model.clips()) {
    const std::span root_path(model.root_path().row(clip.first_frame).data(),
                              3 * static_cast<std::size_t>(clip.frame_count));
    MOTIONDB_ASSIGN_OR_RETURN(keys.emplace_back(),
                              FindModelClip(connection, database_key, clip, root_path));
  }
  return keys;
}

absl::Status InsertLayers(Connection& connection, std::int64_t model_key, const core::Tree& tree) {
  for (int layer = 1; layer <= tree.layer_count(); ++layer) {
    MOTIONDB_RETURN_IF_ERROR(
        connection
            .Query("INSERT INTO model_layer (model_key, layer, node_count) VALUES (?, ?, ?)",
                   model_key, layer, tree.node_count(layer))
            .Run());
  }
  return absl::OkStatus();
}

absl::Status InsertClips(Connection& connection, std::int64_t model_key,
                         const std::vector<std::int64_t>& clip_keys) {
  for (std::size_t position = 0; position < clip_keys.size(); ++position) {
    MOTIONDB_RETURN_IF_ERROR(
        connection
            .Query("INSERT INTO model_clip (model_key, position, clip_key) VALUES (?, ?, ?)",
                   model_key, position, clip_keys[position])
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

// Before memory is taken: whether the clips hold as many states as the model says.
absl::Status CheckStoredStates(Connection& connection, const core::ModelParts& parts,
                               const std::vector<std::int64_t>& clip_keys) {
  if (clip_keys.size() != parts.clips.size()) {
    return core::DataLoss("parts: expected {} clips, got {}", parts.clips.size(), clip_keys.size());
  }
  const std::int64_t frame_bytes = 4 * std::int64_t{parts.marker_set.dimension_count()};
  for (std::size_t c = 0; c < clip_keys.size(); ++c) {
    const core::ModelClip& clip = parts.clips[c];
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t bytes,
                              BlobBytes(connection, ClipOwner(clip_keys[c]), BlobKind::kStates));
    if (bytes < frame_bytes * clip.frame_count) {
      return core::DataLoss("clip '{}': states: expected {} frames, got {} bytes", clip.id,
                            clip.frame_count, bytes);
    }
  }
  return absl::OkStatus();
}

absl::Status ReadStates(Connection& connection, const std::vector<std::int64_t>& clip_keys,
                        core::ModelParts& parts) {
  MOTIONDB_RETURN_IF_ERROR(CheckStoredStates(connection, parts, clip_keys));
  const int dimensions = parts.marker_set.dimension_count();
  parts.states.resize(parts.tree.frame_count(), dimensions);
  parts.root_path.resize(parts.tree.frame_count(), 3);
  for (std::size_t c = 0; c < clip_keys.size(); ++c) {
    const core::ModelClip& clip = parts.clips[c];
    const auto decode = [&](ByteSource& source) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const StatesHeader header, DecodeStatesHeader(source));
      if (header.frame_count != clip.frame_count || header.dimension_count != dimensions) {
        return core::DataLoss("states: expected {} frames of {} dimensions, got {} of {}",
                              clip.frame_count, dimensions, header.frame_count,
                              header.dimension_count);
      }
      const auto frames = static_cast<std::size_t>(clip.frame_count);
      return DecodeStatesFrames(
          source, std::span(parts.states.row(clip.first_frame).data(), frames * dimensions),
          std::span(parts.root_path.row(clip.first_frame).data(), 3 * frames));
    };
    MOTIONDB_RETURN_IF_ERROR(
        In(fmt::format("clip '{}'", clip.id),
           ReadBlob(connection, ClipOwner(clip_keys[c]), BlobKind::kStates, decode)));
  }
  parts.scale.Apply(parts.states);
  return absl::OkStatus();
}

absl::StatusOr<core::Model> ReadModelOf(Connection& connection, std::int64_t model_key) {
  core::ModelParts parts;
  MOTIONDB_RETURN_IF_ERROR(ReadBlob(connection, ModelOwner(model_key), BlobKind::kModel,
                                    [&](ByteSource& source) -> absl::Status {
                                      MOTIONDB_ASSIGN_OR_RETURN(parts, DecodeModel(source));
                                      return absl::OkStatus();
                                    }));
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip_keys, SelectModelClips(connection, model_key));
  MOTIONDB_RETURN_IF_ERROR(ReadStates(connection, clip_keys, parts));
  return core::Model::Create(std::move(parts));
}

}  // namespace

absl::StatusOr<ModelRecord> InsertModel(Connection& connection, const std::string& database,
                                        const core::Model& model, std::int64_t create_time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip_keys, FindModelClips(connection, database_key, model));
  MOTIONDB_ASSIGN_OR_RETURN(const int version, NextVersion(connection, database_key));
  MOTIONDB_RETURN_IF_ERROR(RetireCurrentModel(connection, database_key));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("INSERT INTO model (database_key, version, current, create_time_us, "
                 "build_seconds, frame_count, clip_count, dimension_count) "
                 "VALUES (?, ?, 1, ?, ?, ?, ?, ?)",
                 database_key, version, create_time_us, model.build_seconds(), model.frame_count(),
                 model.clips().size(), model.states().cols())
          .Run());
  const std::int64_t model_key = connection.last_insert_key();
  MOTIONDB_RETURN_IF_ERROR(InsertLayers(connection, model_key, model.tree()));
  MOTIONDB_RETURN_IF_ERROR(InsertClips(connection, model_key, clip_keys));
  MOTIONDB_RETURN_IF_ERROR(
      WriteBlob(connection, ModelOwner(model_key), BlobKind::kModel,
                [&](ByteSink& sink) { return EncodeModel(model.parts(), sink); }));
  return SelectModel(connection, database, version);
}

absl::StatusOr<core::Model> SelectCurrentModel(Connection& connection,
                                               const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(
      "SELECT model_key, version FROM model WHERE database_key = ? AND current = 1", database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return core::NotFound("database '{}' has no model", database);
  auto model = ReadModelOf(connection, row.Integer(0));
  if (!model.ok()) {
    return In(fmt::format("database '{}', model {}", database, row.Integer(1)), model.status());
  }
  return model;
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

absl::Status RetireCurrentModel(Connection& connection, std::int64_t database_key) {
  for (const char* table : {"model_chunk", "model_clip"}) {
    MOTIONDB_RETURN_IF_ERROR(
        connection
            .Query(fmt::format("DELETE FROM {} WHERE model_key IN (SELECT model_key FROM model "
                               "WHERE database_key = ? AND current = 1)",
                               table),
                   database_key)
            .Run());
  }
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE model SET current = 0 WHERE database_key = ? AND current = 1",
                 database_key)
          .Run());
  return PurgeRemovedClips(connection, database_key);
}

}  // namespace motiondb::storage
