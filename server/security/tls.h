// The server's side of TLS: its certificate, that of the authority of its clients, and the watch
// over their files. Thread-safe.
//
// gRPC 1.51 reads certificates again when their files change, but takes a pair that does not match
// as gladly as one that does, and then refuses every connection. So it is given files in memory
// instead, into which go only pairs that were checked: a bad one is logged, and the last good one
// stays.
#pragma once

#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "absl/status/statusor.h"
#include "server/security/certificate_end.h"
#include "server/security/file_watch.h"
#include "server/security/key_pair.h"
#include "server/security/memory_file.h"

namespace motiondb::server {

class Tls {
 public:
  // INVALID_ARGUMENT, naming the file that is wrong. `tell_end` is told when the certificate ends,
  // here and, on a thread of the watch's own, whenever there is another.
  static absl::StatusOr<std::unique_ptr<Tls>> Start(const TlsFiles& files,
                                                    CertificateEnd::Tell tell_end);

  // A client certificate is required where `client_ca` was given. Connections made two seconds
  // after a change of the files see it, those that stand go on.
  const std::shared_ptr<grpc::ServerCredentials>& credentials() const { return credentials_; }

 private:
  Tls(const TlsFiles& files, TlsTexts texts, MemoryFile certificate, MemoryFile key,
      MemoryFile client_ca, CertificateEnd end);
  absl::StatusOr<bool> TakeChange();

  const TlsFiles files_;
  TlsTexts texts_;  // in force
  MemoryFile certificate_;
  MemoryFile key_;
  MemoryFile client_ca_;
  std::shared_ptr<grpc::ServerCredentials> credentials_;
  CertificateEnd end_;
  FileWatch watch_;  // last: it changes what is above
};

}  // namespace motiondb::server
