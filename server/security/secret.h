// The secrets of bearer tokens. A token is `mdb_{id}_{secret}`. The id (48 bits) is public. The
// secret has 256 random bits, so a salted SHA-256 is as safe as a slow password hash.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Returns `bytes` random bytes in hexadecimal. Returns INTERNAL if the random generator fails.
absl::StatusOr<std::string> RandomHex(int bytes);

// Returns the SHA-256 of salt and secret: 32 bytes.
std::string HashSecret(std::string_view salt, std::string_view secret);

// Compares in constant time.
bool SameBytes(std::string_view a, std::string_view b);

struct BearerToken {
  std::string_view id;
  std::string_view secret;
};

// Splits `mdb_{id}_{secret}`. Returns nullopt for another form. The result refers to `text`.
std::optional<BearerToken> SplitToken(std::string_view text);
std::string JoinToken(std::string_view id, std::string_view secret);

}  // namespace motiondb::server
