// The secrets of bearer tokens. A token is `mdb_{id}_{secret}`: the id, 48 bits, is no secret; the
// secret is 256 random bits, so that a plain salted hash keeps it as well as a slow one would. Safe
// to call from any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// `bytes` bytes of the system's randomness in hexadecimal. INTERNAL where the system gives none.
absl::StatusOr<std::string> RandomHex(int bytes);

// SHA-256 of the salt and the secret: 32 bytes.
std::string HashSecret(std::string_view salt, std::string_view secret);

// Takes a time that does not depend on where they differ.
bool SameBytes(std::string_view a, std::string_view b);

struct BearerToken {
  std::string_view id;
  std::string_view secret;
};

// Nothing where the text does not have the form. The result points into the text.
std::optional<BearerToken> SplitToken(std::string_view text);
std::string JoinToken(std::string_view id, std::string_view secret);

}  // namespace motiondb::server
