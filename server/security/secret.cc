#include "server/security/secret.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"

namespace motiondb::server {
namespace {

constexpr std::string_view kPrefix = "mdb_";
// What may follow a token in an error or a log line. None of it can be part of a secret.
constexpr std::string_view kTokenEnds = " \t\r\n/'\"`,;:@()[]{}<>";

}  // namespace

absl::StatusOr<std::string> RandomHex(int bytes) {
  std::string random(static_cast<std::size_t>(bytes), '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(random.data()), bytes) != 1) {
    return absl::InternalError("the system gives no random bytes");
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
  if (!text.starts_with(kPrefix)) return std::nullopt;
  text.remove_prefix(kPrefix.size());
  const std::size_t end = text.find('_');
  if (end == 0 || end == std::string_view::npos || end + 1 == text.size()) return std::nullopt;
  return BearerToken{text.substr(0, end), text.substr(end + 1)};
}

std::string JoinToken(std::string_view id, std::string_view secret) {
  return fmt::format("{}{}_{}", kPrefix, id, secret);
}

std::string WithoutSecrets(std::string_view text) {
  std::string shown;
  while (true) {
    const std::size_t begin = text.find(kPrefix);
    if (begin == std::string_view::npos) return shown.append(text);
    const std::string_view id = text.substr(begin + kPrefix.size(), 2 * kTokenIdBytes);
    const std::size_t end = begin + kPrefix.size() + id.size() + 1;
    if (end > text.size() || text[end - 1] != '_' || !std::ranges::all_of(id, [](char c) {
          return absl::ascii_isxdigit(static_cast<unsigned char>(c));
        })) {
      // No token's beginning: another may begin right after its first letter.
      shown.append(text.substr(0, begin + 1));
      text.remove_prefix(begin + 1);
      continue;
    }
    shown.append(text.substr(0, end)).append("...");
    text.remove_prefix(std::min(text.find_first_of(kTokenEnds, end), text.size()));
  }
}

}  // namespace motiondb::server
