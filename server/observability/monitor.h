// What the server knows about itself, from before its models are read until it ends: the figures
// that metrics and GetServerStatus are made of, and whether it is ready. Nothing is polled: figures
// are read when they are asked for. Thread-safe.
#pragma once

#include <prometheus/registry.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "server/observability/call_meter.h"
#include "server/observability/server_figures.h"
#include "storage/mutex.h"

namespace motiondb::server {

class Engine;

struct MonitorOptions {
  std::vector<std::string> methods;           // see CallMeter
  std::string store_path;                     // of the file whose size is told; empty: none is
  std::chrono::milliseconds slow_call{2000};  // from which on a call is logged as slow; 0: none is
};

struct Readiness {
  bool ready = false;
  std::string reason;  // a line for a person, also where it is ready
};

class Monitor {
 public:
  explicit Monitor(MonitorOptions options);

  CallMeter& calls() { return calls_; }
  ConnectionMeter& connections() { return connections_; }
  std::chrono::milliseconds slow_call() const { return options_.slow_call; }

  // How clients reach the server; said once, before it serves.
  void SetTransport(bool encrypted, bool authenticated);
  // When the first certificate that connections need ends, Unix time in seconds.
  void SetCertificateEnd(std::int64_t time_s) { certificate_end_time_s_ = time_s; }

  // Kept as long as the engine may be read: its end waits for those who read it.
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

  ServerFigures Figures() const;
  // Reads a line from the store, so it may take as long as the disk does.
  Readiness CheckReadiness() const;
  // All metrics in Prometheus' text format, version 0.0.4.
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

// One call as the monitor sees it: counted from its first moment to its last, then timed and
// logged: those that failed by the server's fault as errors, slow ones as warnings, all others on
// the level debug. Used by one thread at a time.
class CallWatch {
 public:
  // The monitor must outlive the watch.
  CallWatch(Monitor& monitor, std::string_view method, CallKind kind);
  // A call that had no end is counted as CANCELLED: its client went away.
  ~CallWatch();
  CallWatch(const CallWatch&) = delete;
  CallWatch& operator=(const CallWatch&) = delete;

  // Once. `message` is the status's, for the log.
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

// A call that has ended.
struct EndedCall {
  std::string method;      // "QueryService.Recognize"
  std::string request_id;  // as the client sent it, or the server made it
  std::string peer;        // address of the client
  CallKind kind = CallKind::kWork;
  absl::StatusCode code = absl::StatusCode::kOk;
  std::string message;  // of the status
  double seconds = 0;
};

// Only work can be slow: how long other calls last is up to somebody else. 0: none is slow.
void LogCall(const EndedCall& call, std::chrono::duration<double> slow);

}  // namespace motiondb::server
