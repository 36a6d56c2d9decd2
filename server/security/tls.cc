#include "server/security/tls.h"

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <ctime>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

using grpc::experimental::FileWatcherCertificateProvider;
using grpc::experimental::TlsServerCredentialsOptions;

constexpr unsigned kGrpcPeriodSeconds = 1;

}  // namespace

absl::StatusOr<std::unique_ptr<Tls>> Tls::Start(const TlsFiles& files,
                                                CertificateEnd::Tell tell_end) {
  MOTIONDB_ASSIGN_OR_RETURN(TlsTexts texts, ReadTlsFiles(files));
  MOTIONDB_ASSIGN_OR_RETURN(MemoryFile certificate, MemoryFile::Make(texts.certificate));
  MOTIONDB_ASSIGN_OR_RETURN(MemoryFile key, MemoryFile::Make(texts.key));
  MOTIONDB_ASSIGN_OR_RETURN(MemoryFile client_ca, MemoryFile::Make(texts.client_ca));
  CertificateEnd end(std::move(tell_end));
  end.Look(texts.first_to_end, texts.end_time_s, std::time(nullptr));
  return std::unique_ptr<Tls>(new Tls(files, std::move(texts), std::move(certificate),
                                      std::move(key), std::move(client_ca), std::move(end)));
}

Tls::Tls(const TlsFiles& files, TlsTexts texts, MemoryFile certificate, MemoryFile key,
         MemoryFile client_ca, CertificateEnd end)
    : files_(files),
      texts_(std::move(texts)),
      certificate_(std::move(certificate)),
      key_(std::move(key)),
      client_ca_(std::move(client_ca)),
      end_(std::move(end)),
      watch_("certificates", files.certificate, [this] { return TakeChange(); }) {
  const bool mutual = !files.client_ca.empty();
  TlsServerCredentialsOptions options(std::make_shared<FileWatcherCertificateProvider>(
      key_.path(), certificate_.path(), mutual ? client_ca_.path() : "", kGrpcPeriodSeconds));
  options.watch_identity_key_cert_pairs();
  if (mutual) options.watch_root_certs();
  options.set_cert_request_type(mutual ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                                       : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  credentials_ = grpc::experimental::TlsServerCredentials(options);
}

absl::StatusOr<bool> Tls::TakeChange() {
  MOTIONDB_ASSIGN_OR_RETURN(const TlsTexts texts, ReadTlsFiles(files_));
  if (texts == texts_) {
    end_.Look(texts_.first_to_end, texts_.end_time_s, std::time(nullptr));
    return false;
  }
  MOTIONDB_RETURN_IF_ERROR(key_.Replace(texts.key));
  MOTIONDB_RETURN_IF_ERROR(certificate_.Replace(texts.certificate));
  MOTIONDB_RETURN_IF_ERROR(client_ca_.Replace(texts.client_ca));
  texts_ = texts;
  end_.Look(texts_.first_to_end, texts_.end_time_s, std::time(nullptr));
  return true;
}

}  // namespace motiondb::server
