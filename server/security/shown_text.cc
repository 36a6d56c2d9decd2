#include "server/security/shown_text.h"

#include "core/format/text_encoding.h"
#include "server/security/secret.h"

namespace motiondb::server {

std::string ShownText(std::string_view text) {
  return core::WithoutDisplayControls(WithoutSecrets(text));
}

}  // namespace motiondb::server
