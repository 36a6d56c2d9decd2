#include "server/rpc/call_entry.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/clock.h"
#include "server/observability/log.h"
#include "server/rpc/call.h"
#include "server/rpc/call_identity.h"
#include "server/rpc/call_memory.h"
#include "server/security/attempt_limit.h"
#include "server/security/authorize.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "server/translate/status_mapping.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kResourceLimit = 256;
// Of requests and answers; 40 s of 34 markers at 60 Hz.
constexpr std::size_t kLarge = 1 << 20;
constexpr std::int64_t kSmall = 64 << 10;  // of which there may be as many as there are calls

using TimePoint = std::chrono::system_clock::time_point;

double Seconds(std::chrono::milliseconds time) { return static_cast<double>(time.count()) / 1000; }

TimePoint Deadline(const CallHost& host, TimePoint of_client, const Method& method) {
  const bool has_own =
      method.request_class == RequestClass::kStream || method.waits || method.pool == Pool::kUpkeep;
  if (has_own) return of_client;
  return std::min(of_client, std::chrono::system_clock::now() + host.limits.options().longest_call);
}

// When a client may itself take its deadline for past, and cancel the call: its clock began to run
// before the call came here, and it told its time rounded up, by a hundredth at most.
TimePoint Earliest(TimePoint of_client) {
  constexpr std::chrono::milliseconds kOnTheWay{20};
  return of_client - (of_client - std::chrono::system_clock::now()) / 100 - kOnTheWay;
}

// For what is not to wait for its turn to be written.
core::Cancelled AtOnce() {
  return [tried = false]() mutable { return std::exchange(tried, true); };
}

CallKind KindOf(const Method& method) {
  if (method.request_class == RequestClass::kStream) return CallKind::kFrames;
  if (method.waits || method.streaming) return CallKind::kWait;
  return CallKind::kWork;
}

}  // namespace

grpc::Status Stopping() {
  return ToGrpcStatus(
      core::WithReason("SERVER_STOPPING", absl::UnavailableError("the server is stopping")));
}

CallEntry::CallEntry(CallHost& host, const grpc::CallbackServerContext& context,
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
      client_may_give_up_(Earliest(client_deadline_)),
      place_(host.limits.Enter(RequestClass::kLight, SourceOf(AddressOf(peer_)))),
      client_(SourceOf(AddressOf(peer_))),
      request_memory_(host.memory, client_),
      response_memory_(host.memory, client_),
      file_memory_(host.memory, client_),
      work_memory_(host.memory, client_),
      ticket_(host.gate, std::move(on_close), [&context] { context.TryCancel(); }) {}

void CallEntry::Weigh(std::size_t request_bytes) {
  const bool is_query = request_class_ == RequestClass::kLight && method_.pool == Pool::kRequests;
  if (is_query && request_bytes > kLarge) request_class_ = RequestClass::kHeavy;
}

grpc::Status CallEntry::Admission() const {
  if (!ticket_.admitted()) return Stopping();
  return ToGrpcStatus(place_.status());
}

void CallEntry::Begin(const google::protobuf::Message& request,
                      std::function<void(grpc::Status)> work) {
  if (const absl::Status held = ReserveRequest(request); !held.ok()) {
    return work(ToGrpcStatus(held));
  }
  host_.engine.workers().Post(Pool::kRequests, [this, &request, work = std::move(work)] {
    const LogFields fields{{"request_id", request_id_}};
    grpc::Status checked = RunHandler(cancelled(), [&] { return Check(request); });
    const bool here = method_.pool == Pool::kRequests && !method_.TakesTurns(request_class_);
    if (!checked.ok() || here) return work(std::move(checked));
    Post([work] { work(grpc::Status::OK); });
  });
}

void CallEntry::BeginHeavy(std::function<void(grpc::Status)> work) {
  request_class_ = RequestClass::kHeavy;
  const absl::Status entered = EnterOwnPlace();
  if (!entered.ok()) return work(ToGrpcStatus(entered));
  Post([work = std::move(work)] { work(grpc::Status::OK); });
}

absl::Status CallEntry::ReserveRequest(const google::protobuf::Message& request) {
  request_size_ = static_cast<std::int64_t>(request.ByteSizeLong());
  const bool counts = request_size_ > kSmall;
  return Resize(request_memory_, counts ? static_cast<std::int64_t>(request.SpaceUsedLong()) : 0);
}

absl::Status CallEntry::ReserveResponse(const google::protobuf::Message& response,
                                        std::size_t bytes) {
  if (bytes <= std::size_t{kSmall}) return absl::OkStatus();
  // As a message, and as the bytes that it is sent as.
  return Resize(response_memory_, static_cast<std::int64_t>(response.SpaceUsedLong() + bytes));
}

absl::Status CallEntry::ReserveFile(std::size_t bytes) {
  file_size_ = static_cast<std::int64_t>(bytes);
  return Resize(file_memory_, file_size_ <= kSmall ? 0 : file_size_);
}

absl::Status CallEntry::ReserveWork(std::int64_t bytes) {
  return Resize(work_memory_, bytes <= kSmall ? 0 : bytes);
}

absl::Status CallEntry::Resize(CallMemory::Reservation& reservation, std::int64_t bytes) {
  const std::int64_t all = request_memory_.bytes() + response_memory_.bytes() +
                           file_memory_.bytes() + work_memory_.bytes() - reservation.bytes() +
                           bytes;
  const std::int64_t most = MostOfOneCall(request_size_ + file_size_);
  if (bytes > reservation.bytes() && all > most) {
    return absl::ResourceExhaustedError(fmt::format(
        "the call needs {:.1f} MiB of memory; one that sends and names {:.1f} MiB may take {:.1f} "
        "MiB: send it in parts or ask for less",
        Mebibytes(all), Mebibytes(request_size_ + file_size_), Mebibytes(most)));
  }
  return reservation.Resize(bytes);
}

void CallEntry::SetClient(const std::string& client) {
  client_ = client;
  for (CallMemory::Reservation* const reservation :
       {&request_memory_, &response_memory_, &file_memory_, &work_memory_}) {
    reservation->SetClient(client);
  }
}

void CallEntry::Post(std::function<void()> work) {
  Workers& workers = host_.engine.workers();
  if (method_.TakesTurns(request_class_)) {
    return workers.PostInTurn(method_.pool, client_, std::move(work));
  }
  workers.Post(method_.pool, std::move(work));
}

core::Cancelled CallEntry::cancelled() const {
  return [this] { return context_.IsCancelled() || std::chrono::system_clock::now() > deadline_; };
}

absl::Status CallEntry::Check(const google::protobuf::Message& request) {
  checked_ = true;
  if (method_.rule == nullptr) {
    return absl::PermissionDeniedError(fmt::format("{}: no role may call it", method_.name));
  }
  const CallRule& rule = *method_.rule;
  if (rule.recorded) resource_ = Subject(request);
  MOTIONDB_ASSIGN_OR_RETURN(Caller caller, Authenticate());
  principal_ = caller.principal;
  const std::string touched = caller.database.empty() ? "" : Subject(request);
  if (rule.scope == Scope::kOperation && !touched.empty()) {
    const auto id = ParseOperationName(rule.field, touched);
    const auto operation = id.ok() ? host_.engine.operations().Get(*id) : id.status();
    MOTIONDB_RETURN_IF_ERROR(
        Authorize(caller, rule, operation.ok() ? DatabaseName(operation->database) : ""));
  } else {
    MOTIONDB_RETURN_IF_ERROR(Authorize(caller, rule, touched));
  }
  if (caller.principal != kAnonymous) SetClient(caller.principal);
  if (CallLimits::HasOwnLimit(request_class_)) MOTIONDB_RETURN_IF_ERROR(EnterOwnPlace());
  caller_ = std::move(caller);
  return absl::OkStatus();
}

absl::Status CallEntry::EnterOwnPlace() {
  MOTIONDB_ASSIGN_OR_RETURN(own_place_, host_.limits.Enter(request_class_, client_));
  return absl::OkStatus();
}

absl::StatusOr<Caller> CallEntry::Authenticate() {
  auto caller = host_.access.Authenticate(EvidenceOf(context_, AddressOf(peer_)));
  if (absl::IsResourceExhausted(caller.status())) host_.monitor.calls().CountRefusedAttempt();
  return caller;
}

absl::Status CallEntry::Recheck() const {
  return caller_.has_value() ? host_.access.Recheck(*caller_)
                             : absl::UnauthenticatedError("the call was not checked");
}

grpc::Status CallEntry::Silent() const {
  const CallLimitOptions& options = host_.limits.options();
  const std::string message =
      checked_ ? fmt::format(
                     "nothing came or went for the {:g} s that a client may be silent "
                     "(--silence-limit)",
                     Seconds(options.longest_silence))
               : fmt::format(
                     "nothing came for the {:g} s that a client may be silent before its "
                     "first message (--silence-limit, at most {:g} s there)",
                     Seconds(host_.limits.first_silence()), Seconds(options.longest_first_silence));
  return ToGrpcStatus(core::WithReason("IDLE_TIMEOUT", absl::DeadlineExceededError(message)));
}

grpc::Status CallEntry::TimeIsUp() const {
  const auto now = std::chrono::system_clock::now();
  if (deadline_ < client_deadline_ && now > deadline_) {
    return ToGrpcStatus(core::WithReason(
        "SERVER_TIME_LIMIT", absl::DeadlineExceededError(fmt::format(
                                 "took longer than the {:g} s that a call may (--call-time-limit)",
                                 Seconds(host_.limits.options().longest_call)))));
  }
  if (now < client_may_give_up_) return grpc::Status::OK;
  return ToGrpcStatus(core::WithReason(
      "CLIENT_DEADLINE",
      absl::DeadlineExceededError("took longer than the deadline that the client set")));
}

grpc::Status CallEntry::End(grpc::Status status, std::size_t answer_bytes) {
  if (status.error_code() == grpc::StatusCode::CANCELLED) {
    if (grpc::Status late = TimeIsUp(); !late.ok()) status = std::move(late);
  }
  if (checked_ && (method_.rule == nullptr || method_.rule->recorded) &&
      !(recorded_ && status.ok())) {
    const bool of_administrator = caller_.has_value() && caller_->role == storage::Role::kAdmin;
    const storage::AuditRecord record = Record(status.error_code());
    const absl::Status kept = host_.access.Record(record, of_administrator, changed_ && status.ok(),
                                                  status.ok() ? cancelled() : AtOnce());
    if (absl::IsCancelled(kept)) host_.engine.RecordLater(record);
  }
  if (answer_bytes <= kLarge) own_place_ = {};  // before the client sees the end, and comes again
  watch_.End(static_cast<absl::StatusCode>(status.error_code()), status.error_message(),
             request_id_, peer());
  ticket_.SetEnded(std::chrono::milliseconds(static_cast<std::int64_t>(answer_bytes) /
                                             kSlowestBytesPerMillisecond));
  return status.ok() ? status : WithRequestInfo(status, request_id_);
}

std::string CallEntry::Subject(const google::protobuf::Message& request) const {
  const CallRule& rule = *method_.rule;
  std::string text = FieldText(request, rule.field);
  return text.empty() ? text : fmt::format("{}{}", rule.collection, text);
}

storage::AuditRecord CallEntry::RecordWithChange(std::string resource) {
  resource_ = std::move(resource);
  recorded_ = true;
  return Record(grpc::StatusCode::OK);
}

storage::AuditRecord CallEntry::Record(grpc::StatusCode code) const {
  storage::AuditRecord record;
  record.time_us = NowMicroseconds();
  record.principal = text::SafeText(principal_);
  record.peer = AddressOf(peer_);
  record.method = method_.name;
  record.resource = text::ValidUtf8(text::SafeText(resource_), kResourceLimit);
  record.code = code;
  record.request_id = request_id_;
  return record;
}

}  // namespace motiondb::server
