// TLS of the server. Reloads its files while the server runs.
#pragma once

#include <openssl/ssl.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "server/security/operator_files.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Reloads files periodically, on its own thread. Logs each reload. Logs a fault once; the previous
// content then stays in use.
class FileReloader {
 public:
  // Reads the files and applies their content. Returns whether the content is new. Runs on the
  // thread of the FileReloader. Its errors must not contain secrets.
  using Take = std::function<absl::StatusOr<bool>()>;

  // `what` names the content for the log ("certificates"); `file` is its path.
  FileReloader(std::string what, std::string file, Take take,
               std::chrono::milliseconds period = std::chrono::seconds(1));
  ~FileReloader();
  FileReloader(const FileReloader&) = delete;
  FileReloader& operator=(const FileReloader&) = delete;

 private:
  void Watch();
  void Look();

  const std::string what_;
  const std::string file_;
  const Take take_;
  const std::chrono::milliseconds period_;
  std::string fault_;  // last fault logged; empty after a success

  storage::Mutex mutex_;
  storage::ConditionVariable wake_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

// Reports when the certificates expire, and warns 14 days before.
class CertificateExpiry {
 public:
  // Receives the expiry of new certificates, Unix time in s.
  using Report = std::function<void(std::int64_t end_time_s)>;

  // `report` may be empty.
  explicit CertificateExpiry(Report report);

  // Checks the certificate in `file` that expires at `end_time_s`; `now_s` is the current time,
  // both Unix time in s. Logs a warning once for each certificate, from 14 days before its expiry.
  void Look(const std::string& file, std::int64_t end_time_s, std::int64_t now_s);

 private:
  Report report_;
  std::int64_t end_time_s_ = 0;  // last value reported
  bool warned_ = false;
};

// Protocol of the connections of a listener. TLS clients select it by ALPN.
enum class TlsProtocol { kHttp2, kHttp1 };

// Sets the only protocol that the server accepts on this connection of Tls::context. Without it
// HTTP/2. A client without ALPN is accepted.
void SetProtocol(SSL& connection, TlsProtocol protocol);

// The TLS context of the server: its certificate and the authorities of its clients. Uses only a
// certificate and key that match; otherwise logs the fault and keeps the previous pair.
class Tls {
 public:
  // Loads the files and watches them. Returns INVALID_ARGUMENT with the path of an invalid file.
  // Calls `report_end` with the expiry here and, on the thread of the FileReloader, for each new
  // certificate.
  static absl::StatusOr<std::unique_ptr<Tls>> Start(const TlsFiles& files,
                                                    CertificateExpiry::Report report_end);

  // Returns the context for new connections: TLS 1.2 or later, no session resumption; SetProtocol
  // selects the protocol of a connection.
  // Requires a client certificate if `client_ca` is set. The files are read every second; an
  // existing connection keeps its context.
  std::shared_ptr<SSL_CTX> context() const;

 private:
  Tls(const TlsFiles& files, TlsContents texts, std::shared_ptr<SSL_CTX> context,
      CertificateExpiry end);
  absl::StatusOr<bool> TakeChange();

  const TlsFiles files_;
  TlsContents texts_;  // in use
  mutable storage::Mutex mutex_;
  std::shared_ptr<SSL_CTX> context_ ABSL_GUARDED_BY(mutex_);
  CertificateExpiry end_;
  FileReloader watch_;  // last member: its thread uses the members above
};

}  // namespace motiondb::server
