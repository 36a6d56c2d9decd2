// Any bytes as a text of PostgreSQL, which takes neither NUL nor invalid UTF-8. A store accepts any
// string, so these are escaped; the order of valid texts stays that of their bytes.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::storage {

// Returns valid UTF-8 without NUL: NUL becomes "\x01" "0", "\x01" becomes "\x01" "1", and a byte
// that is not part of valid UTF-8 "\x01" "2" and two hexadecimal digits. Other texts stay.
std::string ToPostgresText(std::string_view bytes);
// Reverses ToPostgresText.
std::string FromPostgresText(std::string_view text);

}  // namespace motiondb::storage
