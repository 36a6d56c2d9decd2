#include "server/security/tls.h"

#include <fmt/chrono.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <spdlog/spdlog.h>

#include <ctime>
#include <string_view>
#include <utility>

#include "core/motion/error.h"
#include "server/security/pem.h"

namespace motiondb::server {

FileReloader::FileReloader(std::string what, std::string file, Take take,
                           std::chrono::milliseconds period)
    : what_(std::move(what)),
      file_(std::move(file)),
      take_(std::move(take)),
      period_(period),
      thread_([this] { Watch(); }) {}

FileReloader::~FileReloader() {
  {
    const storage::MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.NotifyAll();
  thread_.join();
}

// Reads the content, not the modification time: two changes within one clock tick have the same
// time. The files are small.
void FileReloader::Watch() {
  const storage::MutexLock lock(mutex_);
  const auto stopping = [this] {
    mutex_.AssertHeld();
    return stopping_;
  };
  while (!wake_.WaitUntil(mutex_, storage::WaitClock::now() + period_, stopping)) Look();
}

void FileReloader::Look() {
  const absl::StatusOr<bool> taken = take_();
  if (taken.ok()) {
    fault_.clear();
    if (*taken) spdlog::info("reloaded {}: file={}", what_, file_);
  } else if (fault_ != taken.status().message()) {
    fault_ = std::string(taken.status().message());
    spdlog::warn("cannot reload {}; the previous content stays in use: error={}", what_, fault_);
  }
}

namespace {

constexpr unsigned char kHttp2[] = {2, 'h', '2'};
constexpr unsigned char kHttp1[] = {8, 'h', 't', 't', 'p', '/', '1', '.', '1'};
// The application data of a connection points to this for HTTP/1.1; otherwise it is null.
char http1_mark = 0;

// Selects the only protocol of the connection. OpenSSL does not call this for a client without
// ALPN; the server assumes the protocol of the listener then.
int ChooseProtocol(SSL* connection, const unsigned char** chosen, unsigned char* size,
                   const unsigned char* offered, unsigned offered_size, void*) {
  const bool is_http1 = SSL_get_app_data(connection) == &http1_mark;
  const unsigned char* const protocol = is_http1 ? kHttp1 : kHttp2;
  const unsigned protocol_size = is_http1 ? sizeof(kHttp1) : sizeof(kHttp2);
  unsigned char* found = nullptr;
  if (SSL_select_next_proto(&found, size, protocol, protocol_size, offered, offered_size) !=
      OPENSSL_NPN_NEGOTIATED) {
    return SSL_TLSEXT_ERR_ALERT_FATAL;
  }
  *chosen = found;
  return SSL_TLSEXT_ERR_OK;
}

bool UsePair(SSL_CTX& context, const TlsContents& texts) {
  const PemText chain = ReadPem(texts.certificate);
  const Certificate own = NextCertificate(*chain);
  const PemText key_text = ReadPem(texts.key);
  const Key key = PrivateKey(*key_text);
  if (own == nullptr || SSL_CTX_use_certificate(&context, own.get()) != 1) return false;
  while (Certificate intermediate = NextCertificate(*chain)) {
    if (SSL_CTX_add1_chain_cert(&context, intermediate.get()) != 1) return false;
  }
  return SSL_CTX_use_PrivateKey(&context, key.get()) == 1 &&
         SSL_CTX_check_private_key(&context) == 1;
}

bool RequireClients(SSL_CTX& context, const std::string& authorities) {
  const PemText memory = ReadPem(authorities);
  while (const Certificate authority = NextCertificate(*memory)) {
    if (X509_STORE_add_cert(SSL_CTX_get_cert_store(&context), authority.get()) != 1 ||
        SSL_CTX_add_client_CA(&context, authority.get()) != 1) {
      return false;
    }
  }
  SSL_CTX_set_verify(&context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  return true;
}

absl::StatusOr<std::shared_ptr<SSL_CTX>> MakeContext(const TlsContents& texts) {
  const std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (context == nullptr) return absl::ResourceExhaustedError("TLS: out of memory");
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  // No resumption: a resumed session would stay valid after the client's authority is removed.
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_TICKET |
                                         SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_num_tickets(context.get(), 0);
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  // Idle connections release their buffers.
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE |
                                      SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                      SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_alpn_select_cb(context.get(), ChooseProtocol, nullptr);
  const bool made = UsePair(*context, texts) &&
                    (texts.client_ca.empty() || RequireClients(*context, texts.client_ca));
  if (made) return context;
  const unsigned long error = ERR_get_error();
  ERR_clear_error();
  const char* const reason = ERR_reason_error_string(error);
  return core::InvalidArgument("TLS: cannot use {}: {}", texts.first_to_end,
                               reason == nullptr ? "unknown error" : reason);
}

}  // namespace

void SetProtocol(SSL& connection, TlsProtocol protocol) {
  SSL_set_app_data(&connection, protocol == TlsProtocol::kHttp1 ? &http1_mark : nullptr);
}

absl::StatusOr<std::unique_ptr<Tls>> Tls::Start(const TlsFiles& files,
                                                CertificateExpiry::Report report_end) {
  MOTIONDB_ASSIGN_OR_RETURN(TlsContents texts, ReadTlsFiles(files));
  MOTIONDB_ASSIGN_OR_RETURN(auto context, MakeContext(texts));
  CertificateExpiry end(std::move(report_end));
  end.Look(texts.first_to_end, texts.end_time_s, std::time(nullptr));
  return std::unique_ptr<Tls>(new Tls(files, std::move(texts), std::move(context), std::move(end)));
}

Tls::Tls(const TlsFiles& files, TlsContents texts, std::shared_ptr<SSL_CTX> context,
         CertificateExpiry end)
    : files_(files),
      texts_(std::move(texts)),
      context_(std::move(context)),
      end_(std::move(end)),
      watch_("certificates", files.certificate, [this] { return TakeChange(); }) {}

std::shared_ptr<SSL_CTX> Tls::context() const {
  const storage::MutexLock lock(mutex_);
  return context_;
}

absl::StatusOr<bool> Tls::TakeChange() {
  MOTIONDB_ASSIGN_OR_RETURN(const TlsContents texts, ReadTlsFiles(files_));
  const bool changed = texts != texts_;
  if (changed) {
    MOTIONDB_ASSIGN_OR_RETURN(auto context, MakeContext(texts));
    const storage::MutexLock lock(mutex_);
    context_ = std::move(context);
    texts_ = texts;
  }
  end_.Look(texts_.first_to_end, texts_.end_time_s, std::time(nullptr));
  return changed;
}

namespace {

// Equal to the threshold of the alert in deploy/prometheus.
constexpr std::int64_t kSoonSeconds = std::int64_t{14} * 24 * 3600;

}  // namespace

CertificateExpiry::CertificateExpiry(Report report) : report_(std::move(report)) {}

void CertificateExpiry::Look(const std::string& file, std::int64_t end_time_s, std::int64_t now_s) {
  if (end_time_s != end_time_s_) {
    end_time_s_ = end_time_s;
    warned_ = false;
    if (report_) report_(end_time_s);
  }
  if (warned_ || end_time_s - now_s > kSoonSeconds) return;
  warned_ = true;
  spdlog::warn(
      "{}: a certificate expires on {:%Y-%m-%d %H:%M} UTC; replace the file, the server reloads it "
      "without a restart",
      file, fmt::gmtime(static_cast<std::time_t>(end_time_s)));
}

}  // namespace motiondb::server
