#include "server/security/operator_files.h"

#include <fmt/chrono.h>
#include <openssl/err.h>
#include <openssl/x509.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <sstream>

#include "absl/strings/ascii.h"
#include "core/motion/error.h"
#include "server/security/pem.h"

namespace motiondb::server {

absl::StatusOr<std::string> ReadTextFile(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  // For an empty file operator<< fails, but errno stays 0.
  if (!file || (!(text << file.rdbuf()) && errno != 0)) {
    return core::InvalidArgument("{}: cannot be read: {}", path, std::strerror(errno));
  }
  return text.str();
}

namespace {

constexpr std::size_t kMinTokenLength = 20;

}  // namespace

absl::StatusOr<std::string> ReadAdminToken(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0) {
    return core::InvalidArgument("{}: {}", path, std::strerror(errno));
  }
  if (const std::string_view fault = ModeFault(status.st_mode); !fault.empty()) {
    return core::InvalidArgument("{}: {}; expected mode {}", path, fault, kSecretModes);
  }
  MOTIONDB_ASSIGN_OR_RETURN(std::string text, ReadTextFile(path));
  absl::StripAsciiWhitespace(&text);
  if (text.size() < kMinTokenLength) {
    return core::InvalidArgument("{}: expected a token of at least {} characters", path,
                                 kMinTokenLength);
  }
  if (!std::ranges::all_of(text, absl::ascii_isprint)) {
    return core::InvalidArgument(
        "{}: expected a token on one line, of printable ASCII characters; create one with "
        "`openssl rand -hex 32`",
        path);
  }
  return text;
}

namespace {

std::string DateOf(const ASN1_TIME* time) {
  std::tm parts{};
  return ASN1_TIME_to_tm(time, &parts) == 1 ? fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", parts)
                                            : "an invalid date";
}

// Returns the earliest expiry, Unix time in s, of the certificates in `text`. REQUIRES: at least
// one certificate has a valid date.
std::int64_t FirstEndIn(const std::string& text) {
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  const PemText memory = ReadPem(text);
  while (const Certificate certificate = NextCertificate(*memory)) {
    std::tm parts{};
    if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &parts) != 1) continue;
    first = std::min<std::int64_t>(first, timegm(&parts));
  }
  return first;
}

absl::StatusOr<Certificate> CertificateIn(const std::string& path, const std::string& text) {
  const PemText memory = ReadPem(text);
  Certificate certificate = NextCertificate(*memory);
  if (certificate == nullptr) {
    return core::InvalidArgument("{}: expected a certificate in PEM", path);
  }
  const ASN1_TIME* const end = X509_get0_notAfter(certificate.get());
  if (X509_cmp_current_time(end) < 0) {
    return core::InvalidArgument("{}: the certificate expired on {}; install a new one", path,
                                 DateOf(end));
  }
  return certificate;
}

absl::StatusOr<Key> KeyIn(const std::string& path, const std::string& text) {
  const PemText memory = ReadPem(text);
  Key key = PrivateKey(*memory);
  if (key == nullptr) {
    return core::InvalidArgument("{}: expected a private key in PEM, without a passphrase", path);
  }
  return key;
}

}  // namespace

absl::StatusOr<TlsContents> ReadTlsFiles(const TlsFiles& files) {
  TlsContents texts;
  MOTIONDB_ASSIGN_OR_RETURN(texts.certificate, ReadTextFile(files.certificate));
  MOTIONDB_ASSIGN_OR_RETURN(texts.key, ReadTextFile(files.key));
  MOTIONDB_ASSIGN_OR_RETURN(const Certificate certificate,
                            CertificateIn(files.certificate, texts.certificate));
  texts.end_time_s = FirstEndIn(texts.certificate);
  texts.first_to_end = files.certificate;
  MOTIONDB_ASSIGN_OR_RETURN(const Key key, KeyIn(files.key, texts.key));
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    ERR_clear_error();
    return core::InvalidArgument("{}: is not the key of the certificate in {}", files.key,
                                 files.certificate);
  }
  if (!files.client_ca.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(texts.client_ca, ReadTextFile(files.client_ca));
    MOTIONDB_RETURN_IF_ERROR(CertificateIn(files.client_ca, texts.client_ca).status());
    if (const std::int64_t end = FirstEndIn(texts.client_ca); end < texts.end_time_s) {
      texts.end_time_s = end;
      texts.first_to_end = files.client_ca;
    }
  }
  return texts;
}

}  // namespace motiondb::server
