// A real PostgreSQL cluster in a temporary folder, for the tests of a program: on a Unix socket
// only, without syncs of the disk. As root it runs as the user `postgres`, because PostgreSQL
// refuses to run as root.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>

namespace motiondb::tests {

class PostgresCluster {
 public:
  // Returns the cluster of this program, started by the first call. Null, with a warning of the
  // test, if PostgreSQL is not installed; the test should then return. Requires it if the
  // environment variable MOTIONDB_REQUIRE_POSTGRES is set.
  static PostgresCluster* Find();

  ~PostgresCluster();
  PostgresCluster(const PostgresCluster&) = delete;
  PostgresCluster& operator=(const PostgresCluster&) = delete;

  // Returns the URL of a database. `parameters` as in "&pooled=1".
  std::string Url(const std::string& database, const std::string& parameters = "") const;

  // Run on the database; return the first column of the first row, empty if there is none.
  std::string Sql(const std::string& database, const std::string& script) const;

  // Starts pgbouncer with pool_mode=transaction at the first call. Returns the URL of a database
  // through it; empty, with a warning of the test, if pgbouncer is not installed.
  std::string PooledUrl(const std::string& database);

  // Ends PostgreSQL immediately, as in a crash. Start begins it again, with the same data.
  void Kill();
  void Start();

  // Stops all its processes (SIGSTOP), so that it does not respond, until Resume.
  void Suspend() const { SignalAll(SIGSTOP); }
  void Resume() const { SignalAll(SIGCONT); }

 private:
  explicit PostgresCluster(std::filesystem::path programs);
  void SignalAll(int signal) const;
  // Runs a program (its name, or an absolute path) as the cluster's user; returns its process id.
  pid_t Run(const std::string& program, const std::string& arguments) const;

  const std::filesystem::path programs_;
  std::filesystem::path folder_;
  pid_t process_ = 0;  // of PostgreSQL; 0: it does not run
  pid_t pooler_ = 0;   // of pgbouncer
};

// A database of the cluster, which the destructor drops.
class PostgresDatabase {
 public:
  explicit PostgresDatabase(PostgresCluster& cluster);
  ~PostgresDatabase();
  PostgresDatabase(const PostgresDatabase&) = delete;
  PostgresDatabase& operator=(const PostgresDatabase&) = delete;

  std::string Url(const std::string& parameters = "") const {
    return cluster_.Url(name_, parameters);
  }
  std::string PooledUrl() const { return cluster_.PooledUrl(name_); }
  std::string Sql(const std::string& script) const { return cluster_.Sql(name_, script); }

 private:
  PostgresCluster& cluster_;
  const std::string name_;
};

}  // namespace motiondb::tests
