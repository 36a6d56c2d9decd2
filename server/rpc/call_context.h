// The state that all services share, and the context of one call.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "server/engine/engine.h"
#include "server/engine/work/work_options.h"
#include "server/observability/monitor.h"
#include "server/rpc/call_identity.h"
#include "server/rpc/call_limits.h"
#include "server/rpc/call_registry.h"
#include "server/rpc/running_streams.h"
#include "server/security/access_control.h"
#include "server/security/authorize.h"

namespace motiondb::server {

class OtherServers;

// Shared state of all services.
struct ServiceContext {
  Engine& engine;
  AccessControl access;
  CallLimits limits;
  CallMemory memory;
  CallRegistry registry;
  Monitor& monitor;
  RunningStreams streams = RunningStreams();
  std::shared_ptr<OtherServers> others = nullptr;  // null: the store is not shared
};

// Return UNAVAILABLE, the status of calls that a stopping server cannot accept or finish.
absl::Status ServerStopping();
grpc::Status StoppingStatus();

// Context of one call during its lifetime: method, caller, authorization, limits, memory, metrics,
// log and audit entry. Every reactor has one. Used by one thread at a time.
class CallContext {
 public:
  // `on_close`: see CallRegistry::RegisteredCall. `context` must outlive this.
  CallContext(ServiceContext& host, const grpc::CallbackServerContext& context,
              const Method& method, std::function<void()> on_close = {});

  // Makes a query with a large request, such as a long motion, a heavy call. Call before all other
  // functions.
  void SetRequestSize(std::size_t request_bytes);

  // Returns the error with which to refuse the call, or OK. UNAVAILABLE (the server stops),
  // RESOURCE_EXHAUSTED.
  grpc::Status Admission() const;
  // Reserves memory for the request, runs Check on a request thread, and calls `work` with its
  // status. If OK, `work` runs as by Post; so an unauthorized caller does not wait for a turn.
  // `work` must not throw. The request must outlive the check.
  void Begin(const google::protobuf::Message& request, std::function<void(grpc::Status)> work);
  // For a light call whose work turns out to be heavy: runs `work`, as Begin does, as a heavy call,
  // or with RESOURCE_EXHAUSTED. Precondition: Check returned OK.
  void BeginHeavy(std::function<void(grpc::Status)> work);
  // After the heavy part of a call: frees its turn and the memory of its work.
  void EndHeavy();
  // Work that the request class permits.
  AllowedWork allowed() const {
    return request_class_ == RequestClass::kLight ? AllowedWork::kLightWork : AllowedWork::kAllWork;
  }
  // Runs a further step of the call on a thread of its pool, when the client has its turn. `work`
  // must not throw.
  void Post(std::function<void()> work);
  // As Post, on a thread of Pool::kImports.
  void PostImport(std::function<void()> work);
  // The earlier of the client's deadline and the server's limit.
  std::chrono::system_clock::time_point deadline() const { return deadline_; }
  // True if the deadline has passed or the client has disconnected.
  core::Cancelled cancelled() const;

  // Authenticates and authorizes the call. Call before any work, with the request or the first one
  // of a stream; Begin does it. UNAUTHENTICATED, PERMISSION_DENIED, RESOURCE_EXHAUSTED.
  absl::Status Check(const google::protobuf::Message& request);
  // Checks again for each further message of a stream. UNAUTHENTICATED.
  absl::Status Recheck() const;

  // Returns DEADLINE_EXCEEDED, the status after an idle timeout. The text states whether the first
  // message is missing.
  grpc::Status IdleStatus() const;

  // The Reserve functions reserve memory before it is allocated. A new amount replaces the former
  // one for the same purpose. RESOURCE_EXHAUSTED at the limit for all calls, for this client, or
  // for a call of this size (MaxCallMemory). Small amounts are not counted.

  // For a parsed message, which may be many times its encoded size. Begin does it for the first.
  absl::Status ReserveRequest(const google::protobuf::Message& request);
  // For a response until the client has read it. Never refused after AuditRecordForChange: the
  // change is stored, and a client that gets an error makes it again.
  absl::Status ReserveResponse(const google::protobuf::Message& response, std::size_t bytes);
  // For a file that is sent, or a stored one that the call names; adds to the size of the call.
  absl::Status ReserveFile(std::size_t bytes);
  // For the work.
  absl::Status ReserveWork(std::int64_t bytes);

  // Call once, before the final status is sent. Writes the audit entry if the call's rule requires
  // it, and returns `status` with the request id. From now on the client has the idle timeout, and
  // one second for each 64 kB, to read the response. A call with a large response counts for the
  // limit of its class until the response is read.
  grpc::Status End(grpc::Status status, std::size_t answer_bytes = 0);

  const Method& method() const { return method_; }
  // The caller's `x-request-id`, if it is 1 to 128 printable characters, or one made here.
  const std::string& request_id() const { return request_id_; }
  // In gRPC's format, "ipv4:127.0.0.1:50000".
  const std::string& peer() const { return peer_; }
  // Id of the only database that the caller may see; empty: all.
  std::string database() const { return caller_.has_value() ? caller_->database : ""; }
  // What authenticates the caller.
  PeerCredentials credentials() const { return PeerCredentialsOf(context_, AddressOf(peer_)); }
  // The caller; see AuditEntry.principal.
  std::string principal() const;
  AccessControl& access() { return host_.access; }

  // Returns the audit entry of the call, for the store to write in the transaction of the change.
  // End then writes none unless the call fails. `resource`: name of the changed resource.
  storage::AuditRecord AuditRecordForChange(std::string resource);
  // A successful call that changed nothing: End records it like a failed call.
  void SetUnchanged() { changed_ = recorded_ = false; }
  // A successful call that by its request changes nothing: End writes no audit entry.
  void SetUnrecorded() { recorded_ = true; }

 private:
  absl::StatusOr<Caller> Authenticate();
  absl::Status Resize(CallMemory::Reservation& reservation, std::int64_t bytes);
  void SetClient(const std::string& client);
  absl::Status EnterClass();
  // Returns DEADLINE_EXCEEDED, naming the limit (client or server), if a deadline has expired;
  // otherwise OK.
  grpc::Status DeadlineStatus() const;
  std::string Subject(const google::protobuf::Message& request) const;
  storage::AuditRecord Record(grpc::StatusCode code) const;

  ServiceContext& host_;
  const grpc::CallbackServerContext& context_;
  const Method& method_;
  RequestClass request_class_;
  const std::string peer_;  // a copy: gRPC may drop it when the client disconnects
  const std::string request_id_;
  CallWatch watch_;
  // Read once: gRPC recomputes it at each read, slightly earlier or later.
  const std::chrono::system_clock::time_point client_deadline_;
  const std::chrono::system_clock::time_point deadline_;
  const std::chrono::system_clock::time_point earliest_client_end_;
  const absl::StatusOr<CallLimits::Slot> slot_;  // of all calls
  CallLimits::Slot class_slot_;                  // of its class
  std::string client_;             // key of the limits: the address until the caller is known
  std::int64_t request_size_ = 0;  // bytes of the last message
  std::int64_t file_size_ = 0;
  CallMemory::Reservation request_memory_;
  CallMemory::Reservation response_memory_;
  CallMemory::Reservation file_memory_;
  CallMemory::Reservation work_memory_;
  bool checked_ = false;
  bool recorded_ = false;
  bool changed_ = true;
  std::optional<Caller> caller_;  // set by a successful Check
  std::string principal_ = kAnonymous;
  std::string resource_;
  CallRegistry::RegisteredCall registration_;  // last: destroyed before the other members
};

}  // namespace motiondb::server
