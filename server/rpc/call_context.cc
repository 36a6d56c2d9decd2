#include "server/rpc/call_context.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/work/clock.h"
#include "server/observability/log.h"
#include "server/rpc/call.h"
#include "server/security/attempt_limit.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "server/translate/status_mapping.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxResourceBytes = 256;
// Requests and responses; 40 s of 34 markers at 60 Hz.
constexpr std::size_t kLargeBytes = 1 << 20;
constexpr std::int64_t kSmallBytes = 64 << 10;  // not counted; the number of calls limits the total

using TimePoint = std::chrono::system_clock::time_point;

double Seconds(std::chrono::milliseconds time) { return static_cast<double>(time.count()) / 1000; }

TimePoint Deadline(const ServiceContext& host, TimePoint client_deadline, const Method& method) {
  const bool has_own_limit = method.request_class == RequestClass::kStream || method.waits ||
                             method.pool == Pool::kMaintenance;
  if (has_own_limit) return client_deadline;
  return std::min(client_deadline,
                  std::chrono::system_clock::now() + host.limits.options().max_call_time);
}

// Returns the earliest time at which the client may consider its deadline expired and cancel. Its
// timer started before the call arrived here, and it rounds its timeout up by at most 1 %.
TimePoint EarliestClientEnd(TimePoint client_deadline) {
  constexpr std::chrono::milliseconds kTransitTime{20};
  return client_deadline - (client_deadline - std::chrono::system_clock::now()) / 100 -
         kTransitTime;
}

// Returns a cancellation that permits one attempt: the audit entry does not wait for the writer.
core::Cancelled WithoutWaiting() {
  return [tried = false]() mutable { return std::exchange(tried, true); };
}

CallKind KindOf(const Method& method) {
  if (method.request_class == RequestClass::kStream) return CallKind::kFrames;
  if (method.waits || method.streaming) return CallKind::kWait;
  return CallKind::kWork;
}

}  // namespace

absl::Status ServerStopping() {
  return core::WithReason("SERVER_STOPPING", absl::UnavailableError("the server is stopping"));
}

grpc::Status StoppingStatus() { return ToGrpcStatus(ServerStopping()); }

CallContext::CallContext(ServiceContext& host, const grpc::CallbackServerContext& context,
                         const Method& method, std::function<void()> on_close)
    : host_(host),
      context_(context),
      method_(method),
      request_class_(method.request_class),
      peer_(PeerOf(context)),
      request_id_(RequestIdOf(context)),
      watch_(host.monitor, method.name, KindOf(method)),
      client_deadline_(context.deadline()),
      deadline_(Deadline(host, client_deadline_, method)),
      earliest_client_end_(EarliestClientEnd(client_deadline_)),
      slot_(host.limits.Enter(RequestClass::kLight, AttemptSource(AddressOf(peer_)))),
      client_(AttemptSource(AddressOf(peer_))),
      request_memory_(host.memory, client_),
      response_memory_(host.memory, client_),
      file_memory_(host.memory, client_),
      work_memory_(host.memory, client_),
      registration_(host.registry, std::move(on_close), [&context] { context.TryCancel(); }) {}

void CallContext::SetRequestSize(std::size_t request_bytes) {
  const bool is_query = request_class_ == RequestClass::kLight && method_.pool == Pool::kRequests;
  if (is_query && request_bytes > kLargeBytes) request_class_ = RequestClass::kHeavy;
}

grpc::Status CallContext::Admission() const {
  if (!registration_.admitted()) return StoppingStatus();
  return ToGrpcStatus(slot_.status());
}

void CallContext::Begin(const google::protobuf::Message& request,
                        std::function<void(grpc::Status)> work) {
  if (const absl::Status reserved = ReserveRequest(request); !reserved.ok()) {
    return work(ToGrpcStatus(reserved));
  }
  host_.engine.workers().Post(Pool::kRequests, [this, &request, work = std::move(work)] {
    const LogFields fields{{"request_id", request_id_}};
    grpc::Status checked = RunHandler(cancelled(), [&] { return Check(request); });
    const bool runs_here = method_.pool == Pool::kRequests && !method_.TakesTurns(request_class_);
    if (!checked.ok() || runs_here) return work(std::move(checked));
    Post([work] { work(grpc::Status::OK); });
  });
}

void CallContext::BeginHeavy(std::function<void(grpc::Status)> work) {
  request_class_ = RequestClass::kHeavy;
  const absl::Status entered = EnterClass();
  if (!entered.ok()) return work(ToGrpcStatus(entered));
  Post([work = std::move(work)] { work(grpc::Status::OK); });
}

void CallContext::EndHeavy() {
  request_class_ = RequestClass::kLight;
  class_slot_ = {};
  Resize(work_memory_, 0).IgnoreError();  // a smaller amount is never refused
}

absl::Status CallContext::ReserveRequest(const google::protobuf::Message& request) {
  request_size_ = static_cast<std::int64_t>(request.ByteSizeLong());
  const bool counts = request_size_ > kSmallBytes;
  return Resize(request_memory_, counts ? static_cast<std::int64_t>(request.SpaceUsedLong()) : 0);
}

absl::Status CallContext::ReserveResponse(const google::protobuf::Message& response,
                                          std::size_t bytes) {
  if (bytes <= std::size_t{kSmallBytes}) return absl::OkStatus();
  // The message and its serialized bytes.
  const absl::Status reserved =
      Resize(response_memory_, static_cast<std::int64_t>(response.SpaceUsedLong() + bytes));
  return recorded_ ? absl::OkStatus() : reserved;
}

absl::Status CallContext::ReserveFile(std::size_t bytes) {
  file_size_ = static_cast<std::int64_t>(bytes);
  return Resize(file_memory_, file_size_ <= kSmallBytes ? 0 : file_size_);
}

absl::Status CallContext::ReserveWork(std::int64_t bytes) {
  return Resize(work_memory_, bytes <= kSmallBytes ? 0 : bytes);
}

absl::Status CallContext::Resize(CallMemory::Reservation& reservation, std::int64_t bytes) {
  const std::int64_t total_bytes = request_memory_.bytes() + response_memory_.bytes() +
                                   file_memory_.bytes() + work_memory_.bytes() -
                                   reservation.bytes() + bytes;
  const std::int64_t max_bytes = MaxCallMemory(request_size_ + file_size_);
  if (bytes > reservation.bytes() && total_bytes > max_bytes) {
    return absl::ResourceExhaustedError(fmt::format(
        "the call needs {:.1f} MiB of memory; a call that sends and names {:.1f} MiB may use "
        "{:.1f} MiB: split it or request less",
        Mebibytes(total_bytes), Mebibytes(request_size_ + file_size_), Mebibytes(max_bytes)));
  }
  return reservation.Resize(bytes);
}

void CallContext::SetClient(const std::string& client) {
  client_ = client;
  for (CallMemory::Reservation* const reservation :
       {&request_memory_, &response_memory_, &file_memory_, &work_memory_}) {
    reservation->SetClient(client);
  }
}

void CallContext::Post(std::function<void()> work) {
  Workers& workers = host_.engine.workers();
  if (method_.TakesTurns(request_class_)) {
    return workers.PostFair(method_.pool, client_, std::move(work));
  }
  workers.Post(method_.pool, std::move(work));
}

void CallContext::PostImport(std::function<void()> work) {
  host_.engine.workers().PostFair(Pool::kImports, client_, std::move(work));
}

core::Cancelled CallContext::cancelled() const {
  return [this] { return context_.IsCancelled() || std::chrono::system_clock::now() > deadline_; };
}

absl::Status CallContext::Check(const google::protobuf::Message& request) {
  checked_ = true;
  if (method_.rule == nullptr) {
    return absl::PermissionDeniedError(fmt::format("no role may call {}", method_.name));
  }
  const CallRule& rule = *method_.rule;
  if (rule.recorded) resource_ = Subject(request);
  MOTIONDB_ASSIGN_OR_RETURN(Caller caller, Authenticate());
  principal_ = caller.principal;
  const std::string resource = caller.database.empty() ? "" : Subject(request);
  if (rule.scope == Scope::kOperation && !resource.empty()) {
    const auto id = ParseOperationName(rule.field, resource);
    const auto operation = id.ok() ? host_.engine.operations().Get(*id) : id.status();
    MOTIONDB_RETURN_IF_ERROR(
        Authorize(caller, rule, operation.ok() ? DatabaseName(operation->database) : ""));
  } else {
    MOTIONDB_RETURN_IF_ERROR(Authorize(caller, rule, resource));
  }
  if (caller.principal != kAnonymous) SetClient(caller.principal);
  if (CallLimits::HasOwnLimit(request_class_)) MOTIONDB_RETURN_IF_ERROR(EnterClass());
  caller_ = std::move(caller);
  return absl::OkStatus();
}

absl::Status CallContext::EnterClass() {
  MOTIONDB_ASSIGN_OR_RETURN(class_slot_, host_.limits.Enter(request_class_, client_));
  return absl::OkStatus();
}

absl::StatusOr<Caller> CallContext::Authenticate() {
  auto caller = host_.access.Authenticate(PeerCredentialsOf(context_, AddressOf(peer_)));
  if (absl::IsResourceExhausted(caller.status())) host_.monitor.calls().CountRefusedAttempt();
  return caller;
}

absl::Status CallContext::Recheck() const {
  return caller_.has_value() ? host_.access.Recheck(*caller_)
                             : absl::UnauthenticatedError("the call was not checked");
}

grpc::Status CallContext::IdleStatus() const {
  const CallLimitOptions& options = host_.limits.options();
  const std::string message =
      checked_
          ? fmt::format("idle timeout: nothing sent or received for {:g} s (--silence-limit)",
                        Seconds(options.idle_limit))
          : fmt::format(
                "idle timeout: no first message within {:g} s (--silence-limit, for "
                "the first message at most {:g} s)",
                Seconds(host_.limits.first_message_limit()), Seconds(options.first_idle_limit));
  return ToGrpcStatus(core::WithReason("IDLE_TIMEOUT", absl::DeadlineExceededError(message)));
}

grpc::Status CallContext::DeadlineStatus() const {
  const auto now = std::chrono::system_clock::now();
  if (deadline_ < client_deadline_ && now > deadline_) {
    return ToGrpcStatus(core::WithReason(
        "SERVER_TIME_LIMIT", absl::DeadlineExceededError(
                                 fmt::format("the call took longer than {:g} s (--call-time-limit)",
                                             Seconds(host_.limits.options().max_call_time)))));
  }
  if (now < earliest_client_end_) return grpc::Status::OK;
  return ToGrpcStatus(core::WithReason(
      "CLIENT_DEADLINE",
      absl::DeadlineExceededError("the call took longer than the client's deadline")));
}

grpc::Status CallContext::End(grpc::Status status, std::size_t answer_bytes) {
  if (status.error_code() == grpc::StatusCode::CANCELLED) {
    if (grpc::Status expired = DeadlineStatus(); !expired.ok()) status = std::move(expired);
  }
  if (checked_ && (method_.rule == nullptr || method_.rule->recorded) &&
      !(recorded_ && status.ok())) {
    const bool is_admin = caller_.has_value() && caller_->role == storage::Role::kAdmin;
    const storage::AuditRecord record = Record(status.error_code());
    const absl::Status written = host_.access.Record(record, is_admin, changed_ && status.ok(),
                                                     status.ok() ? cancelled() : WithoutWaiting());
    if (absl::IsCancelled(written)) host_.engine.RecordLater(record);
  }
  if (answer_bytes <= kLargeBytes) class_slot_ = {};  // before the client sees the end and retries
  watch_.End(static_cast<absl::StatusCode>(status.error_code()), status.error_message(),
             request_id_, peer());
  registration_.SetEnded(
      std::chrono::milliseconds(static_cast<std::int64_t>(answer_bytes) / kMinBytesPerMillisecond));
  return status.ok() ? status : WithRequestInfo(status, request_id_);
}

std::string CallContext::Subject(const google::protobuf::Message& request) const {
  const CallRule& rule = *method_.rule;
  std::string text = FieldText(request, rule.field);
  return text.empty() ? text : fmt::format("{}{}", rule.collection, text);
}

std::string CallContext::principal() const { return text::SafeText(principal_); }

storage::AuditRecord CallContext::AuditRecordForChange(std::string resource) {
  resource_ = std::move(resource);
  recorded_ = true;
  return Record(grpc::StatusCode::OK);
}

storage::AuditRecord CallContext::Record(grpc::StatusCode code) const {
  storage::AuditRecord record;
  record.time_us = NowMicroseconds();
  record.principal = principal();
  record.peer = AddressOf(peer_);
  record.method = method_.name;
  record.resource = text::ValidUtf8(text::SafeText(resource_), kMaxResourceBytes);
  record.code = code;
  record.request_id = request_id_;
  return record;
}

}  // namespace motiondb::server
