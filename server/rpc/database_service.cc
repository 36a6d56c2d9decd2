#include <algorithm>
#include <cstdint>
#include <deque>
#include <iterator>
#include <memory>
#include <unordered_map>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/annotation_message.h"
#include "server/translate/message_fields.h"
#include "server/translate/page.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

constexpr char kScope[] = "databases";

absl::Status CreateDatabase(const Call& call, const v1::CreateDatabaseRequest& request,
                            v1::CreateDatabaseResponse& response) {
  MOTIONDB_RETURN_IF_ERROR(CheckDatabaseId("database_id", request.database_id()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto settings, ParseBuildSettings(request.database()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto marker_set,
      ResolveMarkerSet(request.database().marker_set(), request.database().marker_set_file()));
  const auto audit = call.entry.AuditRecordForChange(DatabaseName(request.database_id()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto record,
                            call.engine.CreateDatabase(request.database_id(), settings, marker_set,
                                                       {&audit, call.cancelled}));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(record.name));
  SetDatabase(record, *live, *response.mutable_database());
  return absl::OkStatus();
}

absl::StatusOr<bool> IsFull(v1::DatabaseView view) {
  switch (view) {
    case v1::DATABASE_VIEW_UNSPECIFIED:
    case v1::DATABASE_VIEW_BASIC:
      return false;
    case v1::DATABASE_VIEW_FULL:
      return true;
    default:
      return FieldViolation("view", "unknown view {}; expected basic or full",
                            static_cast<int>(view));
  }
}

absl::Status GetDatabase(const Call& call, const v1::GetDatabaseRequest& request,
                         v1::GetDatabaseResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const bool full, IsFull(request.view()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(id));
  // First: the answer contains at least the changes up to it.
  MOTIONDB_ASSIGN_OR_RETURN(const auto revision, call.engine.store().annotations().Revision(id));
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, call.engine.store().GetDatabase(id));
  SetDatabase(record, *live, *response.mutable_database());
  response.mutable_database()->set_revision(revision);
  if (full) {
    MOTIONDB_ASSIGN_OR_RETURN(const SnapshotPointer snapshot,
                              call.engine.ModelIfAny(*live, call.work_options()));
    SetStatistics(*live, snapshot.get(), *response.mutable_database()->mutable_statistics());
  }
  return absl::OkStatus();
}

// Returns the databases of a page that the caller may see: all, or the only one it has access to.
absl::StatusOr<std::vector<storage::DatabaseRecord>> VisibleDatabases(const Call& call,
                                                                      const storage::Page& page) {
  const std::string only = call.entry.database();
  if (only.empty()) return call.engine.store().ListDatabases(page);
  std::vector<storage::DatabaseRecord> records;
  auto record = call.engine.store().GetDatabase(only);
  if (!record.ok() && !absl::IsNotFound(record.status())) return record.status();
  if (record.ok() && only > page.after) records.push_back(*std::move(record));
  return records;
}

absl::Status ListDatabases(const Call& call, const v1::ListDatabasesRequest& request,
                           v1::ListDatabasesResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string after, DecodePageToken(kScope, request.page_token()));
  std::unordered_map<std::int64_t, std::int64_t> revisions;  // by id
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, call.engine.store().ListDatabaseStates());
  for (const auto& state : states) revisions[state.id] = state.revision;
  MOTIONDB_ASSIGN_OR_RETURN(const auto records, VisibleDatabases(call, {after, size + 1}));
  const auto make = [&](const storage::DatabaseRecord& record, v1::Database& to) {
    to.set_revision(revisions[record.id]);
    if (const auto live = call.engine.FindDatabase(record.name); live.ok()) {
      SetDatabase(record, **live, to);
    } else {  // deleted after it was listed, or not yet served here: only its settings
      SetDatabaseSettings(record, to);
    }
  };
  response.set_next_page_token(FillPageFrom(records, size, kScope, *response.mutable_databases(),
                                            make, [](const auto& record) { return record.name; }));
  return absl::OkStatus();
}

absl::Status DeleteDatabase(const Call& call, const v1::DeleteDatabaseRequest& request,
                            v1::DeleteDatabaseResponse&) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", request.name()));
  const auto audit = call.entry.AuditRecordForChange(request.name());
  return call.engine.DeleteDatabase(id, {&audit, call.cancelled});
}

absl::Status ReprocessDatabase(const Call& call, const v1::ReprocessDatabaseRequest& request,
                               v1::ReprocessDatabaseResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto operation,
                            call.engine.ReprocessDatabase(id, call.cancelled));
  SetOperation(operation, *response.mutable_operation());
  return absl::OkStatus();
}

// The changes of a database after a revision, in order.
class ChangeSource {
 public:
  // `call` must outlive it.
  // `revision`: of the database now.
  ChangeSource(const Call& call, std::shared_ptr<LiveDatabase> database, std::int64_t after,
               std::int64_t revision)
      : call_(call),
        database_(std::move(database)),
        after_(after),
        begun_(after == 0 ? revision : 0) {}

  // AwaitsChange if there is no further change and the client knows that.
  absl::StatusOr<bool> Next(v1::WatchDatabaseResponse& message) {
    if (changes_.empty()) {
      MOTIONDB_RETURN_IF_ERROR(Read());
      if (changes_.empty() && is_up_to_date_) return AwaitsChange();
      if (changes_.empty()) message.set_revision(after_);
    }
    if (!changes_.empty()) {
      after_ = changes_.front().revision;
      SetChange(database_->name(), changes_.front(), message);
      changes_.pop_front();
    }
    is_up_to_date_ = changes_.empty() && !has_more_;
    message.set_up_to_date(is_up_to_date_);
    return true;
  }

 private:
  absl::Status Read() {
    constexpr int kChangesPerRead = 256;
    call_.parking.WakeOn(*database_->signal());
    const std::string& name = database_->name();
    MOTIONDB_ASSIGN_OR_RETURN(const auto current, call_.engine.FindDatabase(name));
    if (current != database_) {
      return core::WithReason(
          "DATABASE_NOT_FOUND",
          core::NotFound("database '{}' was deleted and created again: watch it from 0", name));
    }
    MOTIONDB_ASSIGN_OR_RETURN(auto changes, call_.engine.store().annotations().Changes(
                                                name, after_, kChangesPerRead, begun_));
    has_more_ = std::ssize(changes) >= kChangesPerRead;
    std::ranges::move(changes, std::back_inserter(changes_));
    return absl::OkStatus();
  }

  const Call& call_;
  const std::shared_ptr<LiveDatabase> database_;
  std::int64_t after_;        // revision of the last change that was sent
  const std::int64_t begun_;  // see AnnotationStore::Changes
  std::deque<storage::ChangeRecord> changes_;
  bool has_more_ = false;
  bool is_up_to_date_ = false;  // and the client knows it
};

absl::StatusOr<MessageSource<v1::WatchDatabaseResponse>> OpenWatch(
    const Call& call, const v1::WatchDatabaseRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(auto database, call.engine.FindDatabase(id));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision,
                            call.engine.store().annotations().Revision(id));
  const std::int64_t after = request.after_revision();
  if (after < 0 || after > revision) {
    return FieldViolation("after_revision",
                          "expected 0 to {}, the revision of the database, got {}; watch from 0 "
                          "if the database was restored from a backup",
                          revision, after);
  }
  const auto source = std::make_shared<ChangeSource>(call, std::move(database), after, revision);
  return [source](v1::WatchDatabaseResponse& message) { return source->Next(message); };
}

class DatabaseServiceImpl final : public v1::DatabaseService::CallbackService {
 public:
  explicit DatabaseServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* CreateDatabase(grpc::CallbackServerContext* context,
                                           const v1::CreateDatabaseRequest* request,
                                           v1::CreateDatabaseResponse* response) override {
    return Answer<server::CreateDatabase>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* GetDatabase(grpc::CallbackServerContext* context,
                                        const v1::GetDatabaseRequest* request,
                                        v1::GetDatabaseResponse* response) override {
    return Answer<server::GetDatabase>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListDatabases(grpc::CallbackServerContext* context,
                                          const v1::ListDatabasesRequest* request,
                                          v1::ListDatabasesResponse* response) override {
    return Answer<server::ListDatabases>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* DeleteDatabase(grpc::CallbackServerContext* context,
                                           const v1::DeleteDatabaseRequest* request,
                                           v1::DeleteDatabaseResponse* response) override {
    return Answer<server::DeleteDatabase>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ReprocessDatabase(grpc::CallbackServerContext* context,
                                              const v1::ReprocessDatabaseRequest* request,
                                              v1::ReprocessDatabaseResponse* response) override {
    return Answer<server::ReprocessDatabase>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::WatchDatabaseResponse>* WatchDatabase(
      grpc::CallbackServerContext* context, const v1::WatchDatabaseRequest* request) override {
    return new StreamReactor<v1::WatchDatabaseRequest, v1::WatchDatabaseResponse>(
        host_, context, request, OpenWatch);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeDatabaseService(ServiceContext& host) {
  return std::make_unique<DatabaseServiceImpl>(host);
}

}  // namespace motiondb::server
