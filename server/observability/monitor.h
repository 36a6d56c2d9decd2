// What the server knows about itself, from before its models are read until it ends: the figures
// that metrics and GetServerStatus are made of, and whether it is ready. Nothing is polled: figures
// are read when they are asked for. Thread-safe.
#pragma once

#include <prometheus/registry.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <shared_mutex>
#include <string>
#include <vector>

#include "server/observability/call_meter.h"
#include "server/observability/server_figures.h"

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
  mutable std::shared_mutex engine_mutex_;
  Engine* engine_ = nullptr;
};

}  // namespace motiondb::server
