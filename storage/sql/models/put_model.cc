#include "storage/sql/models/put_model.h"

#include <span>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/chunk_stream.h"
#include "storage/blob/model_codec.h"
#include "storage/sql/models/model_clips.h"
#include "storage/sql/models/model_table.h"
#include "storage/sql/tables/change_feed.h"
#include "storage/sql/tables/database_table.h"

namespace motiondb::storage {
namespace {

constexpr int kModelsKept = 1000;  // model records to keep, per database
// Limits of one transaction, for about ten milliseconds.
constexpr std::ptrdiff_t kPieceClips = 2000;
constexpr std::size_t kPieceBytes = 4 << 20;

// A model that is still being stored is staged, which makes it invisible.
enum class Standing { kStaged, kCurrent };

absl::StatusOr<int> NextVersion(Connection& connection, std::int64_t database_key) {
  Statement row = connection.Query(
      "UPDATE database SET last_model_version = last_model_version + 1 WHERE database_key = ? "
      "RETURNING last_model_version",
      database_key);
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  const int version = row.Integer<int>(0);
  MOTIONDB_RETURN_IF_ERROR(row.Run());
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("database", database_key));
  return version;
}

// Returns a version for a staged model: above all others, until it is published.
absl::StatusOr<int> StagedVersion(Connection& connection, std::int64_t database_key) {
  Statement row = connection.Query(
      "SELECT COALESCE(min(version), 2147483648) - 1 FROM model WHERE database_key = ? AND "
      "staged = 1",
      database_key);
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  return row.Integer<int>(0);
}

absl::Status InsertLayers(Connection& connection, std::int64_t model_key, const core::Tree& tree) {
  const std::string sql = fmt::format(
      "INSERT INTO model_layer (model_key, layer, node_count, row_crc) VALUES (?1, ?2, ?3, {})",
      connection.ChecksumOf("?1, ?2, ?3"));
  for (int layer = 1; layer <= tree.layer_count(); ++layer) {
    MOTIONDB_RETURN_IF_ERROR(
        connection.Query(sql, model_key, layer, tree.node_count(layer)).RunLater());
  }
  return absl::OkStatus();
}

// Inserts the row and the layers of a model; returns its key.
absl::StatusOr<std::int64_t> InsertRecord(Connection& connection, std::int64_t database_key,
                                          int version, const core::Model& model,
                                          std::int64_t create_time_us, Standing standing) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t model_key,
      connection.Insert("model_key",
                        "INSERT INTO model (database_key, version, current, create_time_us, "
                        "build_seconds, frame_count, clip_count, dimension_count, staged) "
                        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                        database_key, version, standing == Standing::kCurrent, create_time_us,
                        model.build_seconds(), model.frame_count(), model.clips().size(),
                        model.states().cols(), standing == Standing::kStaged));
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("model", model_key));
  MOTIONDB_RETURN_IF_ERROR(InsertLayers(connection, model_key, model.tree()));
  return model_key;
}

// Deletes the records of old models, except builds that a kept model extends.
absl::Status DeleteOldRecords(Connection& connection, std::int64_t database_key, int version) {
  const int last = version - kModelsKept;
  return connection
      .Query(
          "DELETE FROM model WHERE database_key = ? AND current = 0 AND staged = 0 AND version <= "
          "? AND "
          "model_key NOT IN (SELECT base_key FROM model WHERE database_key = ? AND version > ? AND "
          "base_key IS NOT NULL)",
          database_key, last, database_key, last)
      .Run();
}

// Returns whether the first clips of `model` are those of the current model.
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

// Gives a model, which has become the current one or was dropped, the next revision.
absl::Status NoteModelChange(Connection& connection, std::int64_t database_key,
                             std::int64_t model_key) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision, NextRevision(connection, database_key));
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE model SET revision = ? WHERE model_key = ?", revision, model_key)
          .Run());
  return connection.SetRowChecksum("model", model_key);
}

absl::Status Supersede(Connection& connection, std::int64_t model_key) {
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE model SET current = 0 WHERE model_key = ?", model_key).Run());
  return connection.SetRowChecksum("model", model_key);
}

// Marks the current model as former. Returns its key; 0 if there is none.
absl::StatusOr<std::int64_t> Retire(Connection& connection, std::int64_t database_key) {
  std::int64_t key = 0;
  {
    Statement current = connection.Query(
        "SELECT model_key FROM model WHERE database_key = ? AND current = 1", database_key);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, current.Step());
    if (!found) return 0;
    key = current.Integer(0);
  }
  MOTIONDB_RETURN_IF_ERROR(Supersede(connection, key));
  return key;
}

// Stores one model in several transactions.
class ModelWriter {
 public:
  ModelWriter(const TransactionRunner& write, const std::string& database, const core::Model& model,
              const ModelTerms& terms)
      : write_(write), database_(database), model_(model), terms_(terms) {}

  absl::StatusOr<ModelRecord> Run(std::int64_t create_time_us) {
    MOTIONDB_RETURN_IF_ERROR(Stage(create_time_us));
    MOTIONDB_RETURN_IF_ERROR(WriteClips());
    MOTIONDB_RETURN_IF_ERROR(WriteChunks());
    return Publish();
  }

 private:
  absl::Status Stage(std::int64_t create_time_us) {
    return write_([&](Connection& connection) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(database_key_, FindDatabase(connection, database_));
      MOTIONDB_RETURN_IF_ERROR(CheckModelTerms(connection, database_, database_key_, terms_));
      MOTIONDB_ASSIGN_OR_RETURN(const int version, StagedVersion(connection, database_key_));
      MOTIONDB_ASSIGN_OR_RETURN(model_key_, InsertRecord(connection, database_key_, version, model_,
                                                         create_time_us, Standing::kStaged));
      return absl::OkStatus();
    });
  }

  // Runs a transaction. NOT_FOUND if the database was deleted meanwhile.
  absl::Status Write(const std::function<absl::Status(Connection&)>& piece) {
    return write_([&](Connection& connection) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindDatabase(connection, database_));
      if (key != database_key_) {
        return core::NotFound("database '{}' was deleted and created again", database_);
      }
      return piece(connection);
    });
  }

  absl::Status WriteClips() {
    const std::ptrdiff_t count = std::ssize(model_.clips());
    for (std::ptrdiff_t first = 0; first < count; first += kPieceClips) {
      const std::ptrdiff_t end = std::min(count, first + kPieceClips);
      const absl::Status written = Write([&](Connection& connection) -> absl::Status {
        MOTIONDB_ASSIGN_OR_RETURN(const auto keys, FindModelClips(connection, database_key_, model_,
                                                                  first, end, DeletedClips::kToo));
        return InsertModelClips(connection, model_key_, first, keys);
      });
      if (!written.ok()) return written;
    }
    return absl::OkStatus();
  }

  // Encodes the model outside of transactions.
  absl::Status WriteChunks() {
    ChunkSink sink(BlobKind::kModel, [&](std::uint32_t position, std::span<const std::byte> chunk) {
      chunks_.emplace_back(position, std::vector(chunk.begin(), chunk.end()));
      chunk_bytes_ += chunk.size();
      return chunk_bytes_ < kPieceBytes ? absl::OkStatus() : FlushChunks();
    });
    MOTIONDB_RETURN_IF_ERROR(EncodeModel(model_.parts(), sink));
    MOTIONDB_RETURN_IF_ERROR(sink.Finish());
    return FlushChunks();
  }

  absl::Status FlushChunks() {
    const absl::Status written = Write([&](Connection& connection) -> absl::Status {
      for (const auto& [position, chunk] : chunks_) {
        MOTIONDB_RETURN_IF_ERROR(
            WriteChunk(connection, ModelOwner(model_key_), BlobKind::kModel, position, chunk));
      }
      return absl::OkStatus();
    });
    chunks_.clear();
    chunk_bytes_ = 0;
    return written;
  }

  absl::StatusOr<ModelRecord> Publish() {
    ModelRecord record;
    const absl::Status published = Write([&](Connection& connection) -> absl::Status {
      MOTIONDB_RETURN_IF_ERROR(CheckModelTerms(connection, database_, database_key_, terms_));
      MOTIONDB_ASSIGN_OR_RETURN(const int version, NextVersion(connection, database_key_));
      MOTIONDB_RETURN_IF_ERROR(Retire(connection, database_key_).status());
      MOTIONDB_RETURN_IF_ERROR(
          connection
              .Query("UPDATE model SET current = 1, staged = 0, version = ? WHERE model_key = ?",
                     version, model_key_)
              .Run());
      MOTIONDB_RETURN_IF_ERROR(NoteModelChange(connection, database_key_, model_key_));
      MOTIONDB_RETURN_IF_ERROR(DeleteOldRecords(connection, database_key_, version));
      MOTIONDB_ASSIGN_OR_RETURN(record, SelectModel(connection, database_, version));
      return absl::OkStatus();
    });
    if (!published.ok()) return published;
    return record;
  }

  const TransactionRunner& write_;
  const std::string& database_;
  const core::Model& model_;
  const ModelTerms& terms_;
  std::int64_t database_key_ = 0;
  std::int64_t model_key_ = 0;
  std::vector<std::pair<std::uint32_t, std::vector<std::byte>>> chunks_;
  std::size_t chunk_bytes_ = 0;
};

// Returns the key of the next model after `after` that has clips or chunks and that the current
// model does not need; 0 if there is none.
absl::StatusOr<std::int64_t> FindUnneeded(Connection& connection, std::int64_t database_key,
                                          std::int64_t after) {
  Statement row = connection.Query(
      "SELECT model_key FROM model WHERE database_key = ?1 AND model_key > ?2 AND current = 0 AND "
      "model_key NOT IN (SELECT base_key FROM model WHERE database_key = ?1 AND current = 1 AND "
      "base_key IS NOT NULL) AND (staged = 1 OR "
      "EXISTS (SELECT 1 FROM model_clip WHERE model_clip.model_key = model.model_key) OR "
      "EXISTS (SELECT 1 FROM model_chunk WHERE model_chunk.model_key = model.model_key)) "
      "ORDER BY model_key LIMIT 1",
      database_key, after);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? row.Integer(0) : 0;
}

// Frees the clips and chunks of a model in several transactions.
absl::Status FreeModel(const TransactionRunner& write, std::int64_t model_key) {
  constexpr int kPieceChunks = 16;
  const auto free_rows = [&](const std::string& sql, auto limit) -> absl::Status {
    bool more = true;
    while (more) {
      const absl::Status freed = write([&](Connection& connection) -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(connection.Query(sql, model_key, limit).Run());
        more = connection.changes() > 0;
        return absl::OkStatus();
      });
      if (!freed.ok()) return freed;
    }
    return absl::OkStatus();
  };
  MOTIONDB_RETURN_IF_ERROR(
      free_rows("DELETE FROM model_clip WHERE (model_key, position) IN (SELECT model_key, position "
                "FROM model_clip WHERE model_key = ? LIMIT ?)",
                kPieceClips));
  MOTIONDB_RETURN_IF_ERROR(
      free_rows("DELETE FROM model_chunk WHERE chunk_key IN (SELECT chunk_key FROM model_chunk "
                "WHERE model_key = ? LIMIT ?)",
                kPieceChunks));
  return write([&](Connection& connection) {
    return connection.Query("DELETE FROM model WHERE model_key = ? AND staged = 1", model_key)
        .Run();
  });
}

}  // namespace

absl::StatusOr<ModelRecord> PutModelInPieces(const TransactionRunner& write,
                                             const std::string& database, const core::Model& model,
                                             std::int64_t create_time_us, const ModelTerms& terms) {
  const absl::Status freed =
      FreeUnneededModels(write, database, terms.fence);  // left by an earlier call
  if (!freed.ok() && !absl::IsDataLoss(freed)) return freed;
  const TransactionRunner fenced = Fenced(write, database, terms.fence);
  auto record = ModelWriter(fenced, database, model, terms).Run(create_time_us);
  // On an error the next call tries again.
  FreeUnneededModels(write, database, terms.fence).IgnoreError();
  return record;
}

absl::Status FreeUnneededModels(const TransactionRunner& write, const std::string& database,
                                std::int64_t fence) {
  const TransactionRunner fenced = Fenced(write, database, fence);
  absl::Status data_loss;
  std::int64_t key = 0;
  while (true) {
    const absl::Status looked = fenced([&](Connection& connection) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const auto database_key, FindDatabase(connection, database));
      MOTIONDB_ASSIGN_OR_RETURN(key, FindUnneeded(connection, database_key, key));
      return absl::OkStatus();
    });
    if (!looked.ok()) return looked;
    if (key == 0) return data_loss;
    data_loss.Update(FreeModel(fenced, key));
  }
}

absl::StatusOr<ModelRecord> InsertExtension(Connection& connection, const std::string& database,
                                            const core::Model& model, double drift_fraction,
                                            std::int64_t create_time_us, const ModelTerms& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_RETURN_IF_ERROR(CheckModelTerms(connection, database, database_key, terms));
  const auto current = FindCurrentModel(connection, database, database_key);
  if (!current.ok() && !absl::IsNotFound(current.status())) return current.status();
  bool extends = current.ok();
  if (extends) {
    MOTIONDB_ASSIGN_OR_RETURN(extends, Extends(connection, model, *current));
  }
  if (!extends) {
    return core::FailedPrecondition("the model does not extend the current model of database '{}'",
                                    database);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip_keys,
                            FindModelClips(connection, database_key, model, current->clip_count,
                                           std::ssize(model.clips()), DeletedClips::kNot));
  MOTIONDB_ASSIGN_OR_RETURN(const int version, NextVersion(connection, database_key));
  MOTIONDB_RETURN_IF_ERROR(Supersede(connection, current->model_key));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t model_key,
      InsertRecord(connection, database_key, version, model, create_time_us, Standing::kCurrent));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE model SET base_key = ?, added_clip_count = ?, added_frame_count = ?, "
                 "stale_share = ? WHERE model_key = ?",
                 current->built_key, std::ssize(model.clips()) - model.built_clip_count(),
                 model.frame_count() - model.built_frame_count(), drift_fraction, model_key)
          .Run());
  MOTIONDB_RETURN_IF_ERROR(NoteModelChange(connection, database_key, model_key));
  MOTIONDB_RETURN_IF_ERROR(
      InsertModelClips(connection, current->built_key, current->clip_count, clip_keys));
  MOTIONDB_RETURN_IF_ERROR(DeleteOldRecords(connection, database_key, version));
  return SelectModel(connection, database, version);
}

absl::Status RetireCurrentModel(Connection& connection, const std::string& database,
                                const ModelTerms& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_RETURN_IF_ERROR(CheckModelTerms(connection, database, database_key, terms));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t dropped, Retire(connection, database_key));
  return dropped == 0 ? absl::OkStatus() : NoteModelChange(connection, database_key, dropped);
}

}  // namespace motiondb::storage
