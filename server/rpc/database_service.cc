#include "core/motion/error.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
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
  MOTIONDB_ASSIGN_OR_RETURN(const auto marker_set, ParseMarkerSet(request.database()));
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
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, call.engine.store().GetDatabase(id));
  SetDatabase(record, *live, *response.mutable_database());
  if (full) {
    SetStatistics(*live, live->lifecycle().snapshot().get(),
                  *response.mutable_database()->mutable_statistics());
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
  MOTIONDB_ASSIGN_OR_RETURN(const auto records, VisibleDatabases(call, {after, size + 1}));
  const auto make = [&](const storage::DatabaseRecord& record, v1::Database& to) {
    if (const auto live = call.engine.FindDatabase(record.name); live.ok()) {
      SetDatabase(record, **live, to);
    } else {  // deleted after it was listed: only its settings
      SetDatabase(record, LiveDatabase(record.name, record.settings), to);
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

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeDatabaseService(ServiceContext& host) {
  return std::make_unique<DatabaseServiceImpl>(host);
}

}  // namespace motiondb::server
