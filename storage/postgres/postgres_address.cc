#include "storage/postgres/postgres_address.h"

#include <libpq-fe.h>

#include <algorithm>
#include <memory>

#include "core/motion/error.h"
#include "storage/store_url.h"

namespace motiondb::storage {
namespace {

constexpr std::string_view kPooled = "pooled=";

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

// Removes the parameter `pooled` from the URL.
absl::Status TakePooled(PostgresAddress& address) {
  const std::size_t question = address.url.find('?');
  if (question == std::string::npos) return absl::OkStatus();
  const std::string query = address.url.substr(question + 1);
  address.url.resize(question);
  char separator = '?';
  for (std::size_t begin = 0; begin <= query.size();) {
    const std::size_t end = std::min(query.find('&', begin), query.size());
    const std::string parameter = query.substr(begin, end - begin);
    begin = end + 1;
    if (parameter.starts_with(kPooled)) {
      const std::string value = parameter.substr(kPooled.size());
      if (value != "0" && value != "1") {
        return core::InvalidArgument("the store's parameter 'pooled' must be 0 or 1");
      }
      address.pooled = value == "1";
    } else if (!parameter.empty()) {
      address.url += separator + parameter;
      separator = '&';
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PostgresAddress> ParsePostgresUrl(std::string_view url) {
  PostgresAddress address{.url = std::string(url)};
  if (!IsPostgresUrl(url)) {
    return core::InvalidArgument("the URL of a PostgreSQL store begins with postgresql://");
  }
  MOTIONDB_RETURN_IF_ERROR(TakePooled(address));
  char* error = nullptr;
  const std::unique_ptr<PQconninfoOption, FreeOptions> options(
      PQconninfoParse(address.url.c_str(), &error));
  PQfreemem(error);  // it can contain the password
  if (options == nullptr) {
    return core::InvalidArgument(
        "cannot parse the URL of the PostgreSQL store (it is not shown: it may contain a "
        "password); expected postgresql://[user[:password]@][host][:port][/database][?parameters]");
  }
  std::string host;
  std::string port;
  std::string database;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    const std::string_view keyword = option->keyword;
    if (keyword == "host") host = option->val;
    if (keyword == "port") port = option->val;
    if (keyword == "dbname") database = option->val;
  }
  address.name =
      fmt::format("postgresql://{}{}{}/{}", host, port.empty() ? "" : ":", port, database);
  return address;
}

}  // namespace motiondb::storage
