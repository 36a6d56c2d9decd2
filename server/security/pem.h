// Certificates and keys in PEM, by OpenSSL.
#pragma once

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

namespace motiondb::server {

using PemText = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

// Without this callback OpenSSL asks for the passphrase of an encrypted key at the terminal.
inline int NoPassphrase(char*, int, int, void*) { return -1; }

// Returns a reader of the text, which must outlive it.
inline PemText ReadPem(const std::string& text) {
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free};
}

// Returns the next certificate; null if there is none.
inline Certificate NextCertificate(BIO& text) {
  Certificate certificate(PEM_read_bio_X509(&text, nullptr, NoPassphrase, nullptr), X509_free);
  ERR_clear_error();
  return certificate;
}

// Returns the private key; null if there is none, or if it needs a passphrase.
inline Key PrivateKey(BIO& text) {
  Key key(PEM_read_bio_PrivateKey(&text, nullptr, NoPassphrase, nullptr), EVP_PKEY_free);
  ERR_clear_error();
  return key;
}

}  // namespace motiondb::server
