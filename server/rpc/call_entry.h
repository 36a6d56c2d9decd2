// One call, from its first moment to its last: which it is, who makes it, whether they may, and how
// it ended. Every reactor holds one. What is to be done for every call (metrics, the log of
// requests, limits) is done here.
//
// Used by one thread at a time, as a call's messages are.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "server/engine/representation.h"
#include "server/observability/monitor.h"
#include "server/rpc/call_host.h"
#include "server/rpc/call_identity.h"
#include "server/security/authorize.h"

namespace motiondb::server {

// What a call ends with that the server, stopping, cannot take or finish: UNAVAILABLE.
grpc::Status Stopping();

class CallEntry {
 public:
  // `on_close` as in CallGate::Ticket. The context must outlive the entry.
  CallEntry(CallHost& host, const grpc::CallbackServerContext& context, const Method& method,
            std::function<void()> on_close = {});

  // A query with a large request, such as a long motion, counts and works as a heavy call. To be
  // told before anything else is asked.
  void Weigh(std::size_t request_bytes);

  // Not OK: the call is to be refused with this. UNAVAILABLE (the server stops),
  // RESOURCE_EXHAUSTED.
  grpc::Status Admission() const;
  // Holds the request, checks it on a request thread and then runs `work`, which must not throw,
  // with what that came to: where it is OK in the place that Post has, so that nobody waits for a
  // turn who may not have one. The request must outlive the check.
  void Begin(const google::protobuf::Message& request, std::function<void(grpc::Status)> work);
  // For a light call whose work turns out to be heavy: runs `work`, as Begin does, in the place of
  // a heavy one, or with RESOURCE_EXHAUSTED. REQUIRES: the call passed its check.
  void BeginHeavy(std::function<void(grpc::Status)> work);
  // What the call may do where it is.
  Allowed allowed() const {
    return request_class_ == RequestClass::kLight ? Allowed::kLightWork : Allowed::kAllWork;
  }
  // Runs a further piece of the call's work, which must not throw, on a thread of its pool, when
  // the client has its turn.
  void Post(std::function<void()> work);
  // The client's deadline or the server's own, whichever comes first.
  std::chrono::system_clock::time_point deadline() const { return deadline_; }
  // The deadline passed or the client went away.
  core::Cancelled cancelled() const;

  // Whether the caller may make this call. To be asked with the request, or with the first of a
  // stream, before anything is done, by Begin or where that does not serve. UNAUTHENTICATED,
  // PERMISSION_DENIED, RESOURCE_EXHAUSTED.
  absl::Status Check(const google::protobuf::Message& request);
  // Whether the caller still may, for each further message of a stream. UNAUTHENTICATED.
  absl::Status Recheck() const;

  // What a call ends with whose client, for as long as it may, sent nothing, before the first
  // message or after another, or took nothing: DEADLINE_EXCEEDED.
  grpc::Status Silent() const;

  // What follows reserves memory before it is allocated, in place of what was reserved for the same
  // purpose before. RESOURCE_EXHAUSTED where it does not fit into what there is for all calls, for
  // this client, or for a call of this size (call_memory.h). Little memory is not counted.

  // For a message as it is read, which may take many times its bytes. Begin does it for the first.
  absl::Status ReserveRequest(const google::protobuf::Message& request);
  // For a response that waits for the client from here on.
  absl::Status ReserveResponse(const google::protobuf::Message& response, std::size_t bytes);
  // For a file that is sent, or a stored one that the call names; it adds to the call's size.
  absl::Status ReserveFile(std::size_t bytes);
  // For what the work itself takes.
  absl::Status ReserveWork(std::int64_t bytes);

  // To be called once, with the status that the call ends with, before it is sent: returns it with
  // the request's id, and keeps what the role table says in the record of changes. From then on the
  // client may take as long to take the answer as it may be silent, and a second for each 64 kB.
  // With a large answer the call keeps its place among those of its class until it is taken.
  grpc::Status End(grpc::Status status, std::size_t answer_bytes = 0);

  const Method& method() const { return method_; }
  // The caller's `x-request-id`, if it is 1 to 128 printable characters, or one made here.
  const std::string& request_id() const { return request_id_; }
  // As gRPC has it: "ipv4:127.0.0.1:50000".
  const std::string& peer() const { return peer_; }
  // The id of the one database that the caller may see; empty: all.
  std::string database() const { return caller_.has_value() ? caller_->database : ""; }
  AccessControl& access() { return host_.access; }

  // The call's entry of the record of changes, for a store that keeps it with the change itself, in
  // one transaction: End then keeps none, unless the call fails after all. `resource` names what is
  // changed.
  storage::AuditRecord RecordWithChange(std::string resource);
  // The call, though it will have done what was asked, changed nothing: End keeps what it keeps of
  // one that failed.
  void NoteNoChange() { changed_ = false; }

 private:
  absl::StatusOr<Caller> Authenticate();
  absl::Status Resize(CallMemory::Reservation& reservation, std::int64_t bytes);
  void SetClient(const std::string& client);
  absl::Status EnterOwnPlace();
  // What a call that nobody waits for any more ends with where that is for lack of time:
  // DEADLINE_EXCEEDED, with whose limit it was. OK: it was not.
  grpc::Status TimeIsUp() const;
  std::string Subject(const google::protobuf::Message& request) const;
  storage::AuditRecord Record(grpc::StatusCode code) const;

  CallHost& host_;
  const grpc::CallbackServerContext& context_;
  const Method& method_;
  RequestClass request_class_;
  const std::string peer_;  // kept: gRPC may forget it when the client goes away
  const std::string request_id_;
  CallWatch watch_;
  // Read once: gRPC works it out anew each time, a little earlier or later.
  const std::chrono::system_clock::time_point client_deadline_;
  const std::chrono::system_clock::time_point deadline_;
  const std::chrono::system_clock::time_point client_may_give_up_;
  const absl::StatusOr<CallLimits::Slot> place_;  // among all calls
  CallLimits::Slot own_place_;                    // among those of its class
  std::string client_;  // whose limits the call counts for: an address until the caller is known
  std::int64_t request_size_ = 0;  // bytes of the last message
  std::int64_t file_size_ = 0;
  CallMemory::Reservation request_memory_;
  CallMemory::Reservation response_memory_;
  CallMemory::Reservation file_memory_;
  CallMemory::Reservation work_memory_;
  bool checked_ = false;
  bool recorded_ = false;
  bool changed_ = true;
  std::optional<Caller> caller_;  // nothing before a Check that the caller passed
  std::string principal_ = kAnonymous;
  std::string resource_;
  CallGate::Ticket ticket_;  // last, so that it is given back before the rest goes
};

}  // namespace motiondb::server
