#include "core/motion/error.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/rpc/wait_reactor.h"
#include "server/translate/operation_message.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

absl::Status GetOperation(const Call& call, const v1::GetOperationRequest& request,
                          v1::GetOperationResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseOperationName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, call.engine.operations().Get(id));
  SetOperation(record, *response.mutable_operation());
  return absl::OkStatus();
}

absl::Status ListOperations(const Call& call, const v1::ListOperationsRequest& request,
                            v1::ListOperationsResponse& response) {
  std::string database = call.entry.database();  // all that the caller may see
  if (!request.database().empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(database, ParseDatabaseName("database", request.database()));
    MOTIONDB_RETURN_IF_ERROR(call.engine.FindDatabase(database).status());
  }
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  const std::string scope = fmt::format("operations of {}", database);
  MOTIONDB_ASSIGN_OR_RETURN(const std::string before, DecodePageToken(scope, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto records,
                            call.engine.operations().List(database, before, size + 1));
  response.set_next_page_token(FillPageFrom(records, size, scope, *response.mutable_operations(),
                                            SetOperation,
                                            [](const auto& record) { return record.id; }));
  return absl::OkStatus();
}

absl::Status CancelOperation(const Call& call, const v1::CancelOperationRequest& request,
                             v1::CancelOperationResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseOperationName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto cancellation,
                            call.engine.CancelOperation(id, call.cancelled));
  if (!cancellation.is_first) call.entry.NoteNoChange();
  SetOperation(cancellation.operation, *response.mutable_operation());
  return absl::OkStatus();
}

class OperationServiceImpl final : public v1::OperationService::CallbackService {
 public:
  explicit OperationServiceImpl(CallHost& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetOperation(grpc::CallbackServerContext* context,
                                         const v1::GetOperationRequest* request,
                                         v1::GetOperationResponse* response) override {
    return Answer<server::GetOperation>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListOperations(grpc::CallbackServerContext* context,
                                           const v1::ListOperationsRequest* request,
                                           v1::ListOperationsResponse* response) override {
    return Answer<server::ListOperations>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* WaitOperation(grpc::CallbackServerContext* context,
                                          const v1::WaitOperationRequest* request,
                                          v1::WaitOperationResponse* response) override {
    return NewWaitReactor(host_, *context, *request, *response);
  }
  grpc::ServerUnaryReactor* CancelOperation(grpc::CallbackServerContext* context,
                                            const v1::CancelOperationRequest* request,
                                            v1::CancelOperationResponse* response) override {
    return Answer<server::CancelOperation>(host_, context, request, response);
  }

 private:
  CallHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeOperationService(CallHost& host) {
  return std::make_unique<OperationServiceImpl>(host);
}

}  // namespace motiondb::server
