#include "storage/postgres/server_table.h"

#include "core/motion/error.h"

namespace motiondb::storage {

absl::Status PutServer(Connection& connection, const ServerAddress& server,
                       std::chrono::milliseconds duration) {
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("DELETE FROM server WHERE expire_time < clock_timestamp()").Run());
  return connection
      .Query(
          "INSERT INTO server (name, address, expire_time) VALUES (?, ?, clock_timestamp() + "
          "?::bigint * interval '1 millisecond') ON CONFLICT (name) DO UPDATE SET address = "
          "excluded.address, expire_time = excluded.expire_time",
          server.name, server.address, std::int64_t{duration.count()})
      .Run();
}

absl::StatusOr<std::vector<ServerAddress>> SelectServers(Connection& connection) {
  std::vector<ServerAddress> servers;
  Statement row = connection.Query(
      "SELECT name, address FROM server WHERE expire_time >= clock_timestamp() ORDER BY name");
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return servers;
    servers.push_back({row.Text(0), row.Text(1)});
  }
}

}  // namespace motiondb::storage
