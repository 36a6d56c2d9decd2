// The server's side of TLS: its certificate, the authority of its clients, and the watch over their
// files. Thread-safe.
//
// Only a pair of files that fits is put in force: a bad one is logged, and the last good one stays.
#pragma once

#include <openssl/ssl.h>

#include <memory>
#include <mutex>

#include "absl/status/statusor.h"
#include "server/security/certificate_end.h"
#include "server/security/file_watch.h"
#include "server/security/key_pair.h"

namespace motiondb::server {

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
  mutable std::mutex mutex_;
  std::shared_ptr<SSL_CTX> context_;
  CertificateEnd end_;
  FileWatch watch_;  // last: it changes what is above
};

}  // namespace motiondb::server
