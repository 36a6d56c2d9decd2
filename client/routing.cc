#include "client/routing.h"

#include <algorithm>

namespace motiondb::client {
namespace {

constexpr std::string_view kDatabases = "databases/";
constexpr std::size_t kMaxIdBytes = 63;

bool IsIdCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
}

}  // namespace

std::string DatabaseIdOf(std::string_view resource_name) {
  if (!resource_name.starts_with(kDatabases)) return "";
  resource_name.remove_prefix(kDatabases.size());
  const std::string_view id = resource_name.substr(0, resource_name.find('/'));
  const bool is_id = id.size() <= kMaxIdBytes && std::all_of(id.begin(), id.end(), IsIdCharacter);
  return is_id ? std::string(id) : "";
}

}  // namespace motiondb::client
