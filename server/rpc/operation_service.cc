#include <algorithm>
#include <chrono>
#include <memory>

#include "core/motion/error.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "server/engine/work/operation_wait.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/translate/message_fields.h"
#include "server/translate/page.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"
#include "storage/mutex.h"

namespace motiondb::server {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kDefaultTimeout{60'000};
constexpr milliseconds kMaxTimeout{24 * 3600 * 1000};

// Returns the wait time. The response must arrive before the deadline: a tenth of the remaining
// time, at most 0.5 s, is reserved for its transfer.
milliseconds UntilDeadline(std::chrono::system_clock::time_point deadline) {
  if (deadline == std::chrono::system_clock::time_point::max()) return kDefaultTimeout;
  const auto remaining =
      std::chrono::duration_cast<milliseconds>(deadline - std::chrono::system_clock::now());
  return std::clamp(remaining - std::min(remaining / 10, milliseconds(500)), milliseconds(0),
                    kMaxTimeout);
}

absl::StatusOr<milliseconds> TimeoutFrom(const v1::WaitOperationRequest& request,
                                         std::chrono::system_clock::time_point deadline) {
  const milliseconds until_deadline = UntilDeadline(deadline);
  if (!request.has_timeout()) return until_deadline;
  const auto& timeout = request.timeout();
  if (timeout.seconds() < 0 || timeout.nanos() < 0 || timeout.nanos() > 999'999'999) {
    return FieldViolation("timeout", "expected a duration of at least 0 s, got {} s {} ns",
                          timeout.seconds(), timeout.nanos());
  }
  const std::int64_t seconds = std::min<std::int64_t>(timeout.seconds(), 24 * 3600);
  const milliseconds given(seconds * 1000 + timeout.nanos() / 1'000'000);
  const bool has_deadline = deadline != std::chrono::system_clock::time_point::max();
  return has_deadline ? std::min(given, until_deadline) : std::min(given, kMaxTimeout);
}

class WaitReactor final : public grpc::ServerUnaryReactor {
 public:
  WaitReactor(ServiceContext& host, grpc::CallbackServerContext& context,
              const v1::WaitOperationRequest& request, v1::WaitOperationResponse& response)
      : entry_(host, context, MethodOf<v1::WaitOperationRequest>()), response_(response) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      Finish(entry_.End(std::move(admission)));
      return;
    }
    entry_.Begin(request, [this, &engine = host.engine, &context, &request](grpc::Status checked) {
      if (!checked.ok()) return Finish(entry_.End(std::move(checked)));
      Start(engine, request, context.deadline());
    });
  }

  void OnCancel() override {
    const storage::MutexLock lock(mutex_);
    cancelled_ = true;
    if (wait_ != nullptr) wait_->Stop();
  }
  void OnDone() override { delete this; }

 private:
  void Start(Engine& engine, const v1::WaitOperationRequest& request,
             std::chrono::system_clock::time_point deadline) {
    const auto id = ParseOperationName("name", request.name());
    const auto timeout = TimeoutFrom(request, deadline);
    const absl::Status valid = id.ok() ? timeout.status() : id.status();
    if (!valid.ok()) return Answer([&] { return valid; });
    const storage::MutexLock lock(mutex_);
    wait_ = OperationWait::Start(engine.workers(), engine.operations(), *id, *timeout,
                                 [this](auto operation) { OnOperation(std::move(operation)); });
    if (cancelled_) wait_->Stop();
  }

  void OnOperation(const absl::StatusOr<storage::OperationRecord>& operation) {
    // Waits until Start has released the lock, because the answer may delete this object.
    { const storage::MutexLock lock(mutex_); }
    Answer([&]() -> absl::Status {
      MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
      if (!operation.ok()) return operation.status();
      SetOperation(*operation, *response_.mutable_operation());
      return absl::OkStatus();
    });
  }

  // Called once, because OperationWait calls back once.
  void Answer(const std::function<absl::Status()>& handler) {
    Finish(entry_.End(RunHandler([] { return false; }, handler)));
  }

  CallContext entry_;
  v1::WaitOperationResponse& response_;
  storage::Mutex mutex_;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<OperationWait> wait_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

grpc::ServerUnaryReactor* NewWaitReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                                         const v1::WaitOperationRequest& request,
                                         v1::WaitOperationResponse& response) {
  return new WaitReactor(host, context, request, response);
}

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
  std::string database = call.entry.database();  // empty: the caller may see all
  if (!request.parent().empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(database, ParseDatabaseName("parent", request.parent()));
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
  if (!cancellation.is_first) call.entry.SetUnchanged();
  SetOperation(cancellation.operation, *response.mutable_operation());
  return absl::OkStatus();
}

class OperationServiceImpl final : public v1::OperationService::CallbackService {
 public:
  explicit OperationServiceImpl(ServiceContext& host) : host_(host) {}

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
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeOperationService(ServiceContext& host) {
  return std::make_unique<OperationServiceImpl>(host);
}

}  // namespace motiondb::server
