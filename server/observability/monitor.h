// Statistics of the server for metrics and GetServerStatus, and its readiness. Exists from before
// models are read until the server ends. Statistics are read on request; nothing is polled.
// Thread-safe.
#pragma once

#include <prometheus/registry.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "server/listen/connection_meter.h"
#include "server/observability/call_meter.h"
#include "server/observability/server_statistics.h"
#include "storage/mutex.h"

namespace motiondb::server {

class Engine;

struct MonitorOptions {
  std::vector<std::string> methods;           // see CallMeter
  std::string store_path;                     // file whose size is reported; empty: none
  std::chrono::milliseconds slow_call{2000};  // minimum duration of a slow call; 0: none
};

struct Readiness {
  bool ready = false;
  std::string reason;  // one line for people; also set if ready
};

class Monitor {
 public:
  explicit Monitor(MonitorOptions options);

  CallMeter& calls() { return calls_; }
  ConnectionMeter& connections() { return connections_; }
  std::chrono::milliseconds slow_call() const { return options_.slow_call; }

  // Call once, before the server serves.
  void SetTransport(bool encrypted, bool authenticated);
  // Expiry of the first certificate that expires, Unix time in seconds.
  void SetCertificateExpiry(std::int64_t time_s) { certificate_end_time_s_ = time_s; }

  // The monitor may read the engine during its lifetime. The destructor waits for readers.
  class Attachment {
   public:
    Attachment(Monitor& monitor, Engine& engine);
    ~Attachment();
    Attachment(const Attachment&) = delete;
    Attachment& operator=(const Attachment&) = delete;

   private:
    Monitor& monitor_;
  };

  void SetPhase(Phase phase) { phase_ = phase; }

  ServerStatistics CollectStatistics() const;
  // Reads from the store, so it may block on the disk.
  Readiness CheckReadiness() const;
  // Returns all metrics in Prometheus' text format 0.0.4.
  std::string Exposition() const;

 private:
  const MonitorOptions options_;
  const std::int64_t start_time_us_;
  prometheus::Registry registry_;
  CallMeter calls_;
  ConnectionMeter connections_;
  std::atomic<Phase> phase_ = Phase::kStarting;
  std::atomic<bool> encrypted_ = false;
  std::atomic<bool> authenticated_ = false;
  std::atomic<std::int64_t> certificate_end_time_s_ = 0;
  mutable storage::SharedMutex engine_mutex_;
  Engine* engine_ ABSL_GUARDED_BY(engine_mutex_) = nullptr;
};

// Counts one call in flight during its lifetime, and measures and logs it at its end. Log level:
// error if the server failed, warning if slow, else debug. Used by one thread at a time.
class CallWatch {
 public:
  // The monitor must outlive the watch.
  CallWatch(Monitor& monitor, std::string_view method, CallKind kind);
  // Counts a call without End as CANCELLED: its client disconnected.
  ~CallWatch();
  CallWatch(const CallWatch&) = delete;
  CallWatch& operator=(const CallWatch&) = delete;

  // Call at most once. `message`: of the status, for the log.
  void End(absl::StatusCode code, const std::string& message, const std::string& request_id,
           const std::string& peer);

 private:
  double Count(absl::StatusCode code);

  Monitor& monitor_;
  CallMeter::Method& method_;
  const CallKind kind_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  bool ended_ = false;
};

// A call that has ended, for the log.
struct EndedCall {
  std::string method;      // "QueryService.Recognize"
  std::string request_id;  // from the client, or made by the server
  std::string peer;        // address of the client
  CallKind kind = CallKind::kWork;
  absl::StatusCode code = absl::StatusCode::kOk;
  std::string message;  // of the status
  double seconds = 0;
};

// `slow`: minimum duration of a slow call; 0: none. Only calls of kind kWork can be slow.
void LogCall(const EndedCall& call, std::chrono::duration<double> slow);

}  // namespace motiondb::server
