// The server's side of TLS, and the watch over its files, which an operator may replace.
#pragma once

#include <openssl/ssl.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "server/security/key_pair.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Looks after files that an operator may replace while the server runs: reads them again and again;
// what cannot be used is logged, once, and what was read before stays in force. Thread-safe.
class FileWatch {
 public:
  // Reads the files and puts what they hold in force: true if it is something new. Called on a
  // thread of the watch's own, until that is destroyed. Its errors must not hold what is secret.
  using Take = std::function<absl::StatusOr<bool>()>;

  // `what` is read from `file`, for the log: "certificates".
  FileWatch(std::string what, std::string file, Take take,
            std::chrono::milliseconds period = std::chrono::seconds(1));
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

 private:
  void Watch();
  void Look();

  const std::string what_;
  const std::string file_;
  const Take take_;
  const std::chrono::milliseconds period_;
  std::string fault_;  // of the files as they are now, already logged

  storage::Mutex mutex_;
  storage::ConditionVariable wake_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

// The server's side of TLS: its certificate, the authority of its clients, and the watch over their
// files. Thread-safe.
//
// Only a pair of files that fits is put in force: a bad one is logged, and the last good one stays.
class CertificateEnd {
 public:
  // Takes the end of a certificate that is new, Unix time in seconds.
  using Tell = std::function<void(std::int64_t end_time_s)>;

  // `tell` may be empty.
  explicit CertificateEnd(Tell tell);

  // At `now_s` it is one in `file` that ends at `end_time_s`, both Unix time in seconds. Logs a
  // warning from 14 days before on, once for each certificate.
  void Look(const std::string& file, std::int64_t end_time_s, std::int64_t now_s);

 private:
  Tell tell_;
  std::int64_t end_time_s_ = 0;  // as it was told
  bool warned_ = false;
};

class Tls {
 public:
  // INVALID_ARGUMENT, naming the file that is wrong. `tell_end` is told when the certificate ends,
  // here and, on a thread of the watch's own, whenever there is another.
  static absl::StatusOr<std::unique_ptr<Tls>> Start(const TlsFiles& files,
                                                    CertificateEnd::Tell tell_end);

  // What new connections are made with: TLS 1.2 or later, HTTP/2 alone, no session resumption. A
  // client certificate is required where `client_ca` was given. The files are read each second;
  // connections that stand go on with what they began with.
  std::shared_ptr<SSL_CTX> context() const;

 private:
  Tls(const TlsFiles& files, TlsTexts texts, std::shared_ptr<SSL_CTX> context, CertificateEnd end);
  absl::StatusOr<bool> TakeChange();

  const TlsFiles files_;
  TlsTexts texts_;  // in force
  mutable storage::Mutex mutex_;
  std::shared_ptr<SSL_CTX> context_ ABSL_GUARDED_BY(mutex_);
  CertificateEnd end_;
  FileWatch watch_;  // last: it changes what is above
};

}  // namespace motiondb::server
