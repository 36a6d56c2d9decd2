#include "server/translate/damage_message.h"

#include "motiondb/v1/store.pb.h"
#include "server/security/shown_text.h"
#include "server/translate/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kTextLimit = 1024;

}  // namespace

void SetDamage(const storage::Damage& damage, v1::Damage& message) {
  message.set_resource(ValidUtf8(ShownText(damage.resource), kTextLimit));
  message.set_description(ValidUtf8(ShownText(damage.description), kTextLimit));
}

}  // namespace motiondb::server
