// Certificates and keys in PEM, by OpenSSL.
#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

namespace motiondb::server {

using PemText = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

// Returns a reader of the text, which must outlive it.
PemText ReadPem(const std::string& text);

// Returns the next certificate; null if there is none.
Certificate NextCertificate(BIO& text);

// Returns the private key; null if there is none, or if it needs a passphrase.
Key PrivateKey(BIO& text);

}  // namespace motiondb::server
