#include "server/security/pem.h"

#include <openssl/err.h>
#include <openssl/pem.h>

namespace motiondb::server {
namespace {

// Without this callback OpenSSL asks for the passphrase of an encrypted key at the terminal.
int NoPassphrase(char*, int, int, void*) { return -1; }

}  // namespace

PemText ReadPem(const std::string& text) {
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free};
}

Certificate NextCertificate(BIO& text) {
  Certificate certificate(PEM_read_bio_X509(&text, nullptr, NoPassphrase, nullptr), X509_free);
  ERR_clear_error();
  return certificate;
}

Key PrivateKey(BIO& text) {
  Key key(PEM_read_bio_PrivateKey(&text, nullptr, NoPassphrase, nullptr), EVP_PKEY_free);
  ERR_clear_error();
  return key;
}

}  // namespace motiondb::server
