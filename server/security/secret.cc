#include "server/security/secret.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include "absl/strings/escaping.h"
#include "text/display_text.h"

namespace motiondb::server {
absl::StatusOr<std::string> RandomHex(int bytes) {
  std::string random(static_cast<std::size_t>(bytes), '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(random.data()), bytes) != 1) {
    return absl::InternalError("the random generator of OpenSSL failed");
  }
  return absl::BytesToHexString(random);
}

std::string HashSecret(std::string_view salt, std::string_view secret) {
  const std::string salted = fmt::format("{}{}", salt, secret);
  std::string hash(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(salted.data()), salted.size(),
         reinterpret_cast<unsigned char*>(hash.data()));
  return hash;
}

bool SameBytes(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::optional<BearerToken> SplitToken(std::string_view text) {
  if (!text.starts_with(text::kTokenPrefix)) return std::nullopt;
  text.remove_prefix(text::kTokenPrefix.size());
  const std::size_t end = text.find('_');
  if (end == 0 || end == std::string_view::npos || end + 1 == text.size()) return std::nullopt;
  return BearerToken{text.substr(0, end), text.substr(end + 1)};
}

std::string JoinToken(std::string_view id, std::string_view secret) {
  return fmt::format("{}{}_{}", text::kTokenPrefix, id, secret);
}

}  // namespace motiondb::server
