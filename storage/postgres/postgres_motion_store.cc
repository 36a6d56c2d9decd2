#include "storage/postgres/postgres_motion_store.h"

#include <chrono>
#include <system_error>
#include <utility>

#include "core/motion/error.h"
#include "storage/postgres/postgres_connection.h"
#include "storage/postgres/postgres_verifier.h"
#include "storage/postgres/postgres_watch.h"
#include "storage/postgres/text_search.h"
#include "storage/records.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/sql_motion_store_work.h"

namespace motiondb::storage {
namespace {

// Rows of the table `server`: the servers that share the store; see MotionStore. The functions run
// in the caller's transaction.

// Adds or renews a server, and removes those that have expired.
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

// In order of name.
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

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresMotionStore>> PostgresMotionStore::Open(
    const std::string& url, PostgresOptions options) {
  MOTIONDB_ASSIGN_OR_RETURN(PostgresAddress address, ParsePostgresUrl(url));
  address.read_only = options.read_only;
  auto connector = std::make_shared<PostgresConnector>(std::move(address));
  auto opened = PostgresConnection::Open(connector);
  if (!opened.ok() && connector->IsRefused()) {
    return absl::FailedPreconditionError(opened.status().message());
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto first, std::move(opened));
  MOTIONDB_RETURN_IF_ERROR(CheckServerVersion(*first));
  SchemaVersions versions;
  std::unique_ptr<Writer> writer;
  if (options.read_only) {
    MOTIONDB_RETURN_IF_ERROR(InTransaction(*first, Transaction::Kind::kRead, CheckPostgresVersion));
    versions.now = versions.before = std::ssize(PostgresMigrations());
  } else {
    MOTIONDB_RETURN_IF_ERROR(CheckIsComplete(*first));
    MOTIONDB_ASSIGN_OR_RETURN(versions, MigratePostgres(*first));
    try {
      writer = std::make_unique<Writer>(std::move(first));
    } catch (const std::system_error& error) {
      return absl::ResourceExhaustedError(
          fmt::format("cannot start the writer thread: {}", error.what()));
    }
  }
  auto readers = std::make_unique<ReaderPool>(
      [connector]() -> absl::StatusOr<std::unique_ptr<Connection>> {
        MOTIONDB_ASSIGN_OR_RETURN(auto reader, PostgresConnection::Open(connector));
        return std::unique_ptr<Connection>(std::move(reader));
      },
      ReaderPool::Check(), options.reader_count);
  return std::unique_ptr<PostgresMotionStore>(new PostgresMotionStore(
      std::move(connector), versions, std::move(writer), std::move(readers), options));
}

PostgresMotionStore::PostgresMotionStore(std::shared_ptr<PostgresConnector> connector,
                                         SchemaVersions versions, std::unique_ptr<Writer> writer,
                                         std::unique_ptr<ReaderPool> readers,
                                         const PostgresOptions& options)
    : SqlMotionStore(std::move(writer), std::move(readers), options.now_us),
      connector_(std::move(connector)),
      versions_(versions),
      read_only_(options.read_only) {}

absl::Status PostgresMotionStore::CheckWrites() {
  // On a full disk small writes can succeed: only a test write shows that there is space again.
  const std::int64_t no_space = write_health().failures().no_space;
  if (!write_health().is_suspect() && no_space == tried_no_space_) return absl::OkStatus();
  return write_health().Try([this, no_space] {
    absl::Status tried = TryWriting();
    if (tried.ok()) tried_no_space_ = no_space;
    return tried;
  });
}

ConnectionStatistics PostgresMotionStore::connections() const {
  ConnectionStatistics statistics = SqlMotionStore::connections();
  statistics.opened_sessions = connector_->opened();
  statistics.failed_sessions = connector_->failed();
  return statistics;
}

absl::StatusOr<std::int64_t> PostgresMotionStore::LeaseTimeUs(Connection& connection) {
  return connection.QueryInteger(
      "SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint");
}

absl::Status PostgresMotionStore::TryWriting() {
  constexpr std::chrono::seconds kMaxWait{1};
  const auto latest = std::chrono::steady_clock::now() + kMaxWait;
  return Write(
      Priority::kUrgent,
      [](Connection& connection) {
        // The table needs new space, about that of a small clip, as an addition does.
        return connection.Execute(
            "CREATE TEMP TABLE motiondb_probe ON COMMIT DROP AS "
            "SELECT repeat('x', 1000) FROM generate_series(1, 256); "
            "UPDATE motiondb_schema SET version = version");
      },
      [&] { return std::chrono::steady_clock::now() > latest; });
}

absl::StatusOr<std::vector<TextMatch>> PostgresMotionStore::SearchClips(const std::string& database,
                                                                        const std::string& query) {
  return Read(
      [&](Connection& connection) { return SearchPostgresTexts(connection, database, query); });
}

absl::Status PostgresMotionStore::AnnounceServer(const ServerAddress& server,
                                                 std::chrono::milliseconds duration) {
  MOTIONDB_RETURN_IF_ERROR(CheckIsWritable());
  return Write(Priority::kUrgent,
               [&](Connection& connection) { return PutServer(connection, server, duration); });
}

absl::StatusOr<std::vector<ServerAddress>> PostgresMotionStore::ListServers() {
  return Read(SelectServers);
}

std::unique_ptr<StoreWatch> PostgresMotionStore::WatchChanges(OnStoreChange on_change) {
  if (connector_->address().pooled) return nullptr;
  return PostgresWatch::Start(connector_->address(), std::move(on_change));
}

absl::Status PostgresMotionStore::CheckIsWritable() const {
  if (!read_only_) return absl::OkStatus();
  return core::FailedPrecondition(
      "the store is open read-only: restart motiondbd without --read-only to change it");
}

absl::StatusOr<std::unique_ptr<StoreVerifier>> PostgresMotionStore::BeginVerify(
    core::Cancelled cancelled) {
  return std::make_unique<PostgresVerifier>(
      [this](const SqlVerifier::Look& look) { return Read(look); }, std::vector<Corruption>(),
      std::move(cancelled));
}

}  // namespace motiondb::storage
