#include "server/translate/damage_message.h"

#include "motiondb/v1/store.pb.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kTextLimit = 1024;

}  // namespace

void SetDamage(const storage::Damage& damage, v1::Damage& message) {
  message.set_resource(text::ValidUtf8(text::SafeText(damage.resource), kTextLimit));
  message.set_description(text::ValidUtf8(text::SafeText(damage.description), kTextLimit));
}

}  // namespace motiondb::server
