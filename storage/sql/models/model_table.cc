#include "storage/sql/models/model_table.h"

#include <functional>
#include <limits>
#include <utility>

#include "core/model/model_builder.h"
#include "core/motion/error.h"
#include "storage/blob/clip_codec.h"
#include "storage/blob/model_codec.h"
#include "storage/clip_segments.h"
#include "storage/sql/models/model_clips.h"
#include "storage/sql/tables/clip_table.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/operation_table.h"
#include "storage/sql/tables/segment_table.h"

namespace motiondb::storage {
namespace {

// Returns a query for the columns that ToModelRecord reads. `rest` ends the WHERE clause.
std::string SelectModels(std::string_view rest) {
  return fmt::format(
      "SELECT model_key, version, current, create_time_us, build_seconds, frame_count, clip_count, "
      "dimension_count, added_clip_count, added_frame_count, stale_share FROM model "
      "WHERE database_key = ? AND staged = 0 AND {}",
      rest);
}

absl::StatusOr<ModelRecord> ToModelRecord(Connection& connection, const std::string& database,
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
  record.drift_fraction = row.Real(10);
  Statement layer = connection.Query(
      "SELECT node_count FROM model_layer WHERE model_key = ? ORDER BY layer", row.Integer(0));
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, layer.Step());
    if (!found) return record;
    record.nodes_per_layer.push_back(layer.Integer<std::int32_t>(0));
  }
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

// Reads the clips that extend a build, as input of core::ExtendModel.
absl::StatusOr<std::vector<core::BuildInput>> ReadAddedClips(Connection& connection,
                                                             std::span<const std::int64_t> keys) {
  std::vector<core::BuildInput> inputs;
  for (const std::int64_t key : keys) {
    Statement row = connection.Query(
        "SELECT clip.id, subject, name, database_key FROM clip JOIN database USING (database_key) "
        "WHERE clip_key = ?",
        key);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return core::DataLoss("a clip that was added to the model is missing");
    core::BuildInput& input = inputs.emplace_back();
    input.clip_id = row.Text(0);
    input.subject = row.Text(1);
    // A deleted clip keeps its segments as long as a model uses it.
    MOTIONDB_ASSIGN_OR_RETURN(
        const auto segments,
        SelectSegments(connection, {row.Integer(3), key, row.Text(2), input.clip_id}));
    const auto decode = [&](ByteSource& source) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(input.states, DecodeStates(source));
      return absl::OkStatus();
    };
    MOTIONDB_RETURN_IF_ERROR(In(fmt::format("clip '{}'", input.clip_id),
                                ReadBlob(connection, ClipOwner(key), BlobKind::kStates, decode)));
    input.labels = LabelTracksOf(segments, input.states.frame_rate_hz, input.states.frame_count());
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
    // Errors of helpers are ignored: the first connection reads the remaining clips.
    if (i > 0) return states->ReadPending(*connections[i]).IgnoreError();
    read = ReadBlob(first, ModelOwner(current.built_key), BlobKind::kModel,
                    [&](ByteSource& source) -> absl::Status {
                      MOTIONDB_ASSIGN_OR_RETURN(parts, DecodeModel(source));
                      return absl::OkStatus();
                    });
    if (read.ok()) read = states->ReadPending(first);
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

}  // namespace

absl::StatusOr<CurrentModel> FindCurrentModel(Connection& connection, const std::string& database,
                                              std::int64_t database_key) {
  Statement row = connection.Query(
      "SELECT model_key, COALESCE(base_key, model_key), version, clip_count, frame_count "
      "FROM model WHERE database_key = ? AND current = 1",
      database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found)
    return core::WithReason("NO_MODEL", core::NotFound("database '{}' has no model", database));
  return CurrentModel{row.Integer(0), row.Integer(1), row.Integer<int>(2), row.Integer<int>(3),
                      row.Integer<int>(4)};
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

absl::StatusOr<core::Model> SelectExtension(Connection& connection, const std::string& database,
                                            std::int32_t base_version, const core::Model& base,
                                            const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const CurrentModel current,
                            FindCurrentModel(connection, database, database_key));
  Statement row = connection.Query(
      "SELECT COALESCE(base_key, model_key), clip_count FROM model WHERE database_key = ? AND "
      "version = ? AND staged = 0",
      database_key, base_version);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  const auto base_clips = static_cast<std::int64_t>(base.clips().size());
  if (!found || row.Integer(0) != current.built_key || row.Integer(1) != base_clips ||
      base_clips > current.clip_count) {
    return core::FailedPrecondition("model {} of database '{}' does not extend model {}",
                                    current.version, database, base_version);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto keys, SelectModelClips(connection, current.built_key));
  if (std::ssize(keys) != current.clip_count) {
    return core::DataLoss("parts: expected {} clips, got {}", current.clip_count, keys.size());
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      auto inputs, ReadAddedClips(connection, std::span(keys).subspan(base.clips().size())));
  if (inputs.empty()) return base;
  return core::ExtendModel(base, std::move(inputs), parallel);
}

absl::StatusOr<ModelStaleness> SelectModelStaleness(Connection& connection,
                                                    const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  const auto current = FindCurrentModel(connection, database, database_key);
  if (!current.ok() && !absl::IsNotFound(current.status())) return current.status();
  const std::int64_t built_key = current.ok() ? current->built_key : 0;
  ModelStaleness staleness;
  Statement missing = connection.Query(
      "SELECT id FROM clip WHERE database_key = ? AND deleted = 0 AND representation_version = ? "
      "AND clip_key NOT IN (SELECT clip_key FROM model_clip WHERE model_key = ?) ORDER BY id",
      database_key, core::kRepresentationVersion, built_key);
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, missing.Step());
    if (!found) break;
    staleness.missing.emplace_back(missing.Text(0));
  }
  Statement known = connection.Query(
      "SELECT count(*) FILTER (WHERE deleted = 1), "
      "count(*) FILTER (WHERE representation_version <> ?) "
      "FROM model_clip JOIN clip USING (clip_key) WHERE model_key = ?",
      core::kRepresentationVersion, built_key);
  MOTIONDB_RETURN_IF_ERROR(known.Step().status());
  staleness.removed = known.Integer<int>(0);
  staleness.outdated = known.Integer<int>(1);
  Statement to_derive = connection.Query(
      "SELECT count(*) FROM clip WHERE database_key = ? AND deleted = 0 AND tried_version < ?",
      database_key, core::kRepresentationVersion);
  MOTIONDB_RETURN_IF_ERROR(to_derive.Step().status());
  staleness.to_derive = to_derive.Integer<int>(0);
  return staleness;
}

absl::StatusOr<ModelRecord> SelectModel(Connection& connection, const std::string& database,
                                        int version) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectModels("version = ?"), database_key, version);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found)
    return core::WithReason("MODEL_NOT_FOUND",
                            core::NotFound("database '{}' has no model {}", database, version));
  return ToModelRecord(connection, database, row);
}

absl::StatusOr<std::vector<ModelRecord>> SelectModels(Connection& connection,
                                                      const std::string& database, int before,
                                                      int limit) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  const std::int64_t below = before > 0 ? before : std::numeric_limits<std::int64_t>::max();
  Statement row = connection.Query(SelectModels("version < ? ORDER BY version DESC LIMIT ?"),
                                   database_key, below, limit);
  std::vector<ModelRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToModelRecord(connection, database, row));
  }
}

absl::Status CheckModelTerms(Connection& connection, const std::string& database,
                             std::int64_t database_key, const ModelTerms& terms) {
  MOTIONDB_RETURN_IF_ERROR(CheckFence(connection, database_key, terms.fence));
  if (!terms.base_version) return absl::OkStatus();
  const auto current = FindCurrentModel(connection, database, database_key);
  if (!current.ok() && !absl::IsNotFound(current.status())) return current.status();
  const int version = current.ok() ? current->version : 0;
  if (version == *terms.base_version) return absl::OkStatus();
  return absl::AbortedError(fmt::format(
      "the model of database '{}' was computed from model {}, but the current one is {}", database,
      *terms.base_version, version));
}

TransactionRunner Fenced(const TransactionRunner& write, const std::string& database,
                         std::int64_t fence) {
  return [&write, &database, fence](const std::function<absl::Status(Connection&)>& piece) {
    return write([&](Connection& connection) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const auto database_key, FindDatabase(connection, database));
      MOTIONDB_RETURN_IF_ERROR(CheckFence(connection, database_key, fence));
      return piece(connection);
    });
  };
}

}  // namespace motiondb::storage
