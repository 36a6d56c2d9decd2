#include "storage/sql/sql_motion_store.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "storage/sql/models/model_table.h"
#include "storage/sql/models/put_model.h"
#include "storage/sql/sql_motion_store_work.h"
#include "storage/sql/tables/access_tables.h"
#include "storage/sql/tables/added_bytes.h"
#include "storage/sql/tables/clip_table.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/deleted_databases.h"
#include "storage/sql/tables/operation_table.h"
#include "storage/sql/tables/skeleton_table.h"

namespace motiondb::storage {
namespace {

std::int64_t ToMicroseconds(std::chrono::milliseconds duration) {
  return std::chrono::microseconds(duration).count();
}

std::int64_t SystemTimeUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

SqlMotionStore::SqlMotionStore(std::unique_ptr<Writer> writer, std::unique_ptr<ReaderPool> readers,
                               std::function<std::int64_t()> now_us)
    : writer_(std::move(writer)),
      readers_(std::move(readers)),
      now_us_(now_us ? std::move(now_us) : SystemTimeUs) {}

void SqlMotionStore::CloseConnections() {
  readers_.reset();
  writer_.reset();
}

absl::Status SqlMotionStore::CreateDatabase(const DatabaseRecord& record,
                                            const WriteOptions& terms) {
  return WriteWith(
      terms, [&](Connection& connection) { return InsertDatabase(connection, record); }, Added(0));
}

absl::StatusOr<DatabaseRecord> SqlMotionStore::GetDatabase(const std::string& database) {
  return Read([&](Connection& connection) { return SelectDatabase(connection, database); });
}

absl::StatusOr<std::vector<DatabaseRecord>> SqlMotionStore::ListDatabases(const Page& page) {
  return Read([&](Connection& connection) { return SelectDatabases(connection, page); });
}

absl::Status SqlMotionStore::ReplaceMarkerSet(const std::string& database,
                                              const std::string& before, const std::string& text,
                                              const WriteOptions& terms) {
  const auto replace = [&](Connection& connection) {
    return UpdateMarkerSetText(connection, database, before, text);
  };
  return WriteWith(terms, replace, Added(static_cast<std::int64_t>(text.size())));
}

absl::Status SqlMotionStore::DeleteDatabase(const std::string& database,
                                            const WriteOptions& terms) {
  const auto remove = [&](Connection& connection) {
    return MarkDatabaseDeleted(connection, database, terms.database_id);
  };
  return WriteWith({terms.audit, terms.cancelled}, remove);
}

absl::StatusOr<std::vector<DatabaseState>> SqlMotionStore::ListDatabaseStates() {
  return Read([](Connection& connection) { return SelectDatabaseStates(connection); });
}

absl::Status SqlMotionStore::PurgeDeletedDatabases(const core::Cancelled& cancelled) {
  const auto write = [this](const auto& piece) { return Write(Priority::kBackground, piece); };
  return FreeDeletedDatabases(write, staged_, cancelled);
}

absl::StatusOr<ClipRecord> SqlMotionStore::AddClip(const NewClip& clip) {
  const auto insert = [&](Connection& connection) -> absl::StatusOr<ClipRecord> {
    MOTIONDB_ASSIGN_OR_RETURN(ClipRecord added, InsertClip(connection, clip));
    if (clip.audit) {
      MOTIONDB_RETURN_IF_ERROR(InsertAuditRecord(connection, clip.audit(added)));
    }
    return added;
  };
  const Writer::Transact transact = [this](Connection& writer, std::int64_t added_bytes,
                                           const Writer::Body& body) {
    return Transact(writer, added_bytes, body);
  };
  MOTIONDB_RETURN_IF_ERROR(CheckIsWritable());
  auto added = writer_->RunShared(transact, AddedBytes(clip), clip.cancelled, insert);
  write_health_.Note(added.status());
  return added;
}

absl::StatusOr<ClipRecord> SqlMotionStore::FindSameClip(const NewClip& clip) {
  return Read([&](Connection& connection) { return SelectSameClip(connection, clip); });
}

absl::StatusOr<ClipRecord> SqlMotionStore::ReplaceClip(const ClipRecord& before,
                                                       const NewClip& clip) {
  const auto replace = [&](Connection& connection,
                           FreePolicy remains) -> absl::StatusOr<ClipRecord> {
    MOTIONDB_ASSIGN_OR_RETURN(ClipRecord added,
                              storage::ReplaceClip(connection, before, clip, remains));
    if (clip.audit) {
      MOTIONDB_RETURN_IF_ERROR(InsertAuditRecord(connection, clip.audit(added)));
    }
    return added;
  };
  return WriteAndFree({nullptr, clip.cancelled}, replace, Added(AddedBytes(clip)));
}

absl::StatusOr<ClipRecord> SqlMotionStore::GetClip(const std::string& database,
                                                   const std::string& clip) {
  return Read([&](Connection& connection) { return SelectClip(connection, database, clip); });
}

absl::StatusOr<std::vector<ClipRecord>> SqlMotionStore::ListClips(const std::string& database,
                                                                  const Page& page) {
  return Read([&](Connection& connection) { return SelectClips(connection, database, page); });
}

absl::StatusOr<ClipRecord> SqlMotionStore::DeleteClip(const std::string& database,
                                                      const std::string& clip,
                                                      const WriteOptions& terms) {
  return WriteAndFree(terms, [&](Connection& connection, FreePolicy remains) {
    return RemoveClip(connection, database, clip, remains);
  });
}

absl::StatusOr<ClipSource> SqlMotionStore::ReadClipSource(const std::string& database,
                                                          const std::string& clip) {
  return Read([&](Connection& connection) { return SelectClipSource(connection, database, clip); });
}

absl::StatusOr<core::StateSequence> SqlMotionStore::ReadClipStates(const std::string& database,
                                                                   const std::string& clip) {
  return Read([&](Connection& connection) { return SelectClipStates(connection, database, clip); });
}

absl::StatusOr<std::vector<ClipRecord>> SqlMotionStore::PutDerived(
    const std::string& database, std::span<const DerivedClip> clips, std::int64_t fence) {
  std::int64_t added = 0;
  for (const DerivedClip& clip : clips) added += AddedBytes(clip);
  return Write(
      Priority::kBackground,
      [&](Connection& connection) { return PutDerivedClips(connection, database, clips, fence); },
      {}, Added(added));
}

absl::StatusOr<core::Skeleton> SqlMotionStore::GetSkeleton(const std::string& database,
                                                           const std::string& skeleton) {
  return Read(
      [&](Connection& connection) { return SelectSkeleton(connection, database, skeleton); });
}

absl::StatusOr<std::vector<SkeletonRecord>> SqlMotionStore::ListSkeletons(
    const std::string& database, const Page& page) {
  return Read([&](Connection& connection) { return SelectSkeletons(connection, database, page); });
}

absl::StatusOr<ModelRecord> SqlMotionStore::PutModel(const std::string& database,
                                                     const core::Model& model,
                                                     const ModelTerms& terms) {
  const MutexLock lock(models_mutex_);
  // Check the room for the whole model before the first transaction.
  Added added = checks_room() ? AddedBytes(model) : 0;
  const TransactionRunner write = [&](const auto& piece) {
    return Write(Priority::kBackground, piece, {}, std::exchange(added, Added(0)));
  };
  auto record = PutModelInPieces(write, database, model, now_us_(), terms);
  if (record.ok())
    PurgeDeletedClips(database, {}).IgnoreError();  // clips that only the former model used
  return record;
}

absl::StatusOr<ModelRecord> SqlMotionStore::PutExtension(const std::string& database,
                                                         const core::Model& model,
                                                         double drift_fraction,
                                                         const ModelTerms& terms) {
  const auto insert = [&](Connection& connection) {
    return InsertExtension(connection, database, model, drift_fraction, now_us_(), terms);
  };
  return Write(Priority::kOrdinary, insert, {}, Added(0));
}

absl::StatusOr<core::Model> SqlMotionStore::ReadModel(const std::string& database,
                                                      const core::ParallelFor& parallel) {
  return Read([&](Connection& connection) -> absl::StatusOr<core::Model> {
    std::vector<ReaderPool::Lease> helpers;
    if (readers_ != nullptr) helpers = readers_->AcquireIdle();
    std::vector<Transaction> transactions;
    std::vector<Connection*> connections = {&connection};
    for (const ReaderPool::Lease& helper : helpers) {
      auto begun = Transaction::Begin(helper.connection(), Transaction::Kind::kRead);
      if (!begun.ok()) continue;
      transactions.push_back(*std::move(begun));
      connections.push_back(&helper.connection());
    }
    return SelectCurrentModel(connections, database, parallel);
  });
}

absl::StatusOr<core::Model> SqlMotionStore::ReadExtension(const std::string& database,
                                                          std::int32_t base_version,
                                                          const core::Model& base,
                                                          const core::ParallelFor& parallel) {
  return Read([&](Connection& connection) {
    return SelectExtension(connection, database, base_version, base, parallel);
  });
}

absl::StatusOr<ModelStaleness> SqlMotionStore::FindModelStaleness(const std::string& database) {
  return Read([&](Connection& connection) { return SelectModelStaleness(connection, database); });
}

absl::StatusOr<ModelRecord> SqlMotionStore::GetModel(const std::string& database, int version) {
  return Read([&](Connection& connection) { return SelectModel(connection, database, version); });
}

absl::StatusOr<std::vector<ModelRecord>> SqlMotionStore::ListModels(const std::string& database,
                                                                    int before, int limit) {
  return Read(
      [&](Connection& connection) { return SelectModels(connection, database, before, limit); });
}

absl::Status SqlMotionStore::DropModel(const std::string& database, const ModelTerms& terms) {
  const MutexLock lock(models_mutex_);
  MOTIONDB_RETURN_IF_ERROR(Write(Priority::kOrdinary, [&](Connection& connection) {
    return RetireCurrentModel(connection, database, terms);
  }));
  const auto write = [this](const auto& piece) { return Write(Priority::kBackground, piece); };
  FreeUnneededModels(write, database, terms.fence).IgnoreError();
  PurgeDeletedClips(database, {}).IgnoreError();
  return absl::OkStatus();
}

absl::Status SqlMotionStore::PurgeDeletedClips(const std::string& database,
                                               const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto keys, Read([&](Connection& connection) {
                              return SelectRemovedClips(connection, database);
                            }));
  if (keys.empty()) return absl::OkStatus();
  // Small transactions, so that other writes do not wait long.
  constexpr std::size_t kPieceClips = 64;
  const auto purge = [&](std::span<const std::int64_t> batch) {
    const auto piece = [&](Connection& connection) { return PurgeRemovedClips(connection, batch); };
    return Write(Priority::kBackground, piece, cancelled);
  };
  absl::Status data_loss;
  for (std::size_t first = 0; first < keys.size(); first += kPieceClips) {
    const auto batch =
        std::span(keys).subspan(first).first(std::min(kPieceClips, keys.size() - first));
    const absl::Status purged = purge(batch);
    if (!absl::IsDataLoss(purged)) {
      MOTIONDB_RETURN_IF_ERROR(purged);
      continue;
    }
    // A clip cannot be freed: purge each clip in its own transaction.
    data_loss = purged;
    for (const std::int64_t& key : batch) {
      const absl::Status single = purge(std::span(&key, 1));
      if (!single.ok() && !absl::IsDataLoss(single)) return single;
    }
  }
  return data_loss;
}

absl::StatusOr<std::int64_t> SqlMotionStore::AcquireBuildLease(const std::string& database,
                                                               const std::string& holder,
                                                               std::chrono::milliseconds duration) {
  return Write(Priority::kUrgent, [&](Connection& connection) -> absl::StatusOr<std::int64_t> {
    // The time after the database is locked.
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindDatabase(connection, database));
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t now_us, LeaseTimeUs(connection));
    return AcquireLease(connection, key, holder, now_us, now_us + ToMicroseconds(duration));
  });
}

absl::Status SqlMotionStore::RenewBuildLease(const std::string& database, std::int64_t fence,
                                             std::chrono::milliseconds duration) {
  return Write(Priority::kUrgent, [&](Connection& connection) -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindDatabase(connection, database));
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t now_us, LeaseTimeUs(connection));
    return RenewLease(connection, key, fence, now_us + ToMicroseconds(duration));
  });
}

absl::Status SqlMotionStore::ReleaseBuildLease(const std::string& database, std::int64_t fence) {
  return Write(Priority::kUrgent, [&](Connection& connection) -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindDatabase(connection, database));
    return ReleaseLease(connection, key, fence);
  });
}

absl::Status SqlMotionStore::PutOperation(const OperationRecord& record,
                                          const core::Cancelled& cancelled) {
  const bool stops = record.state == OperationState::kCancelled;
  return Write(
      stops ? Priority::kUrgent : Priority::kOrdinary,
      [&](Connection& connection) { return UpsertOperation(connection, record); }, cancelled);
}

absl::StatusOr<OperationRecord> SqlMotionStore::GetOperation(const std::string& operation) {
  return Read([&](Connection& connection) { return SelectOperation(connection, operation); });
}

absl::StatusOr<std::vector<OperationRecord>> SqlMotionStore::ListOperations(
    const std::string& database, const std::string& before, int limit) {
  return Read([&](Connection& connection) {
    return SelectOperations(connection, database, before, limit);
  });
}

absl::StatusOr<std::vector<OperationRecord>> SqlMotionStore::ListUnfinishedOperations() {
  return Read([](Connection& connection) { return SelectUnfinishedOperations(connection); });
}

absl::Status SqlMotionStore::AddToken(const TokenRecord& record, const WriteOptions& terms) {
  return WriteWith(terms, [&](Connection& connection) { return InsertToken(connection, record); });
}

absl::StatusOr<TokenRecord> SqlMotionStore::GetToken(const std::string& id) {
  return Read([&](Connection& connection) { return SelectToken(connection, id); });
}

absl::StatusOr<std::vector<TokenRecord>> SqlMotionStore::ListTokens(const std::string& after,
                                                                    int limit) {
  return Read([&](Connection& connection) { return SelectTokens(connection, after, limit); });
}

absl::StatusOr<TokenRecord> SqlMotionStore::RevokeToken(const std::string& id, std::int64_t time_us,
                                                        const WriteOptions& terms) {
  return WriteWith(
      terms, [&](Connection& connection) { return MarkTokenRevoked(connection, id, time_us); },
      Added(), Priority::kUrgent);
}

absl::Status SqlMotionStore::AddAuditRecord(const AuditRecord& record,
                                            const core::Cancelled& cancelled) {
  return Write(
      Priority::kUrgent,
      [&](Connection& connection) { return InsertAuditRecord(connection, record); }, cancelled);
}

absl::StatusOr<std::vector<AuditRecord>> SqlMotionStore::ListAuditRecords(std::int64_t before,
                                                                          int limit) {
  return Read(
      [&](Connection& connection) { return SelectAuditRecords(connection, before, limit); });
}

}  // namespace motiondb::storage
