// Which database a call is about, for proxies that send each database to one server.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace motiondb::client {

// Metadata key of calls about a database; its value is the id of the database. A proxy can hash it
// (deploy/nginx/motiondb.conf). Servers ignore it.
inline constexpr char kDatabaseKey[] = "motiondb-database";

// Returns "walks" for "databases/walks" and the names in it. Empty for other names, and for ids
// that no database has: metadata must be printable ASCII, and the server reports the wrong name.
inline std::string DatabaseIdOf(std::string_view resource_name) {
  constexpr std::string_view kDatabases = "databases/";
  constexpr std::size_t kMaxIdBytes = 63;
  const auto is_id_character = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  if (!resource_name.starts_with(kDatabases)) return "";
  resource_name.remove_prefix(kDatabases.size());
  const std::string_view id = resource_name.substr(0, resource_name.find('/'));
  const bool is_id = id.size() <= kMaxIdBytes && std::all_of(id.begin(), id.end(), is_id_character);
  return is_id ? std::string(id) : "";
}

// Returns the id of the database that a request names in its first field, or in the name of its
// object; empty if it names none.
template <typename Request>
std::string DatabaseOf(const Request& request) {
  if constexpr (requires { request.database_id(); }) {
    return DatabaseIdOf("databases/" + request.database_id());
  } else if constexpr (requires { std::string_view(request.database()); }) {
    return DatabaseIdOf(request.database());
  } else if constexpr (requires { request.parent(); }) {
    return DatabaseIdOf(request.parent());
  } else if constexpr (requires { request.name(); }) {
    return DatabaseIdOf(request.name());
  } else if constexpr (requires { request.header(); }) {
    return DatabaseIdOf(request.header().parent());
  } else if constexpr (requires { request.clip().name(); }) {
    return DatabaseIdOf(request.clip().name());
  } else if constexpr (requires { request.segment().name(); }) {
    return DatabaseIdOf(request.segment().name());
  } else {
    return "";
  }
}

}  // namespace motiondb::client
