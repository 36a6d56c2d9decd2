#include "tests/storage/postgres/postgres_cluster.h"

#include <fcntl.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

namespace motiondb::tests {
namespace {

namespace fs = std::filesystem;

constexpr char kUser[] = "motiondb";

// Returns the folder with `initdb` and `postgres`; empty if they are not installed. Debian does not
// put them on the path.
fs::path FindPrograms() {
  const fs::path versions = "/usr/lib/postgresql";
  std::error_code ignored;
  fs::path found;
  for (const auto& version : fs::directory_iterator(versions, ignored)) {
    const fs::path programs = version.path() / "bin";
    const bool is_complete = fs::exists(programs / "initdb") && fs::exists(programs / "postgres");
    if (is_complete && programs > found) found = programs;
  }
  return found;
}

// Changes the user of this process from root to `postgres`.
bool LeaveRoot() {
  if (geteuid() != 0) return true;
  const passwd* const user = getpwnam("postgres");
  return user != nullptr && setgid(user->pw_gid) == 0 && setuid(user->pw_uid) == 0;
}

std::string TextOf(const fs::path& file) {
  FILE* const stream = std::fopen(file.c_str(), "r");
  if (stream == nullptr) return "";
  std::string text(4096, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), stream));
  std::fclose(stream);
  return text;
}

}  // namespace

PostgresCluster* PostgresCluster::Find() {
  static const fs::path kPrograms = FindPrograms();
  if (kPrograms.empty()) {
    WARN("skipped: PostgreSQL is not installed (deploy/install_packages.sh test)");
    REQUIRE(std::getenv("MOTIONDB_REQUIRE_POSTGRES") == nullptr);
    return nullptr;
  }
  static PostgresCluster cluster(kPrograms);
  cluster.Start();  // a failed test can have killed it
  return &cluster;
}

PostgresCluster::PostgresCluster(fs::path programs) : programs_(std::move(programs)) {
  std::string pattern = (fs::temp_directory_path() / "motiondb-pg-XXXXXX").string();
  REQUIRE(mkdtemp(pattern.data()) != nullptr);
  folder_ = pattern;
  if (geteuid() == 0) {
    const passwd* const user = getpwnam("postgres");
    REQUIRE(user != nullptr);
    REQUIRE(chown(folder_.c_str(), user->pw_uid, user->pw_gid) == 0);
  }
  const pid_t made = Run("initdb", std::string("-A trust -E UTF8 --locale=C --no-sync -U ") +
                                       kUser + " -D " + (folder_ / "data").string());
  int status = 0;
  REQUIRE(waitpid(made, &status, 0) == made);
  INFO(TextOf(folder_ / "log"));
  REQUIRE(status == 0);
  Start();
}

PostgresCluster::~PostgresCluster() {
  if (pooler_ != 0) {
    kill(pooler_, SIGQUIT);
    waitpid(pooler_, nullptr, 0);
  }
  Kill();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

pid_t PostgresCluster::Run(const std::string& program, const std::string& arguments) const {
  std::vector<std::string> words = {(programs_ / program).string()};
  std::istringstream rest(arguments);
  for (std::string word; rest >> word;) words.push_back(word);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string log = (folder_ / "log").string();
  const pid_t process = fork();
  REQUIRE(process >= 0);
  if (process != 0) return process;
  // PostgreSQL ends with the test program, whatever happens to it.
  if (!LeaveRoot() || prctl(PR_SET_PDEATHSIG, SIGQUIT) != 0 || chdir(folder_.c_str()) != 0) {
    _exit(1);
  }
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execv(pointers[0], pointers.data());
  _exit(1);
}

void PostgresCluster::Start() {
  if (process_ != 0) return;
  process_ = Run("postgres", "-D " + (folder_ / "data").string() + " -k " + folder_.string() +
                                 " -c listen_addresses= -c fsync=off -c full_page_writes=off "
                                 "-c max_connections=60 -c shared_buffers=32MB -c autovacuum=off");
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (PQping(Url("postgres").c_str()) != PQPING_OK) {
    INFO(TextOf(folder_ / "log"));
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void PostgresCluster::Kill() {
  if (process_ == 0) return;
  kill(process_, SIGQUIT);  // as pg_ctl -m immediate: the children end too
  waitpid(process_, nullptr, 0);
  process_ = 0;
}

void PostgresCluster::SignalAll(int signal) const {
  const std::string process = std::to_string(process_);
  // First the one that starts others.
  kill(process_, signal);
  std::istringstream children(TextOf(fs::path("/proc") / process / "task" / process / "children"));
  for (pid_t child = 0; children >> child;) kill(child, signal);
}

std::string PostgresCluster::PooledUrl(const std::string& database) {
  constexpr char kPooler[] = "/usr/sbin/pgbouncer";
  const std::string parameters = "&port=6432&pooled=1";
  if (!fs::exists(kPooler)) {
    WARN("skipped: pgbouncer is not installed (deploy/install_packages.sh test)");
    REQUIRE(std::getenv("MOTIONDB_REQUIRE_POSTGRES") == nullptr);
    return "";
  }
  if (pooler_ == 0) {
    const fs::path settings = folder_ / "pgbouncer.ini";
    std::ofstream(settings) << "[databases]\n* = user=" << kUser << " host=" << folder_.string()
                            << "\n[pgbouncer]\npool_mode = transaction\nauth_type = any\n"
                               "listen_port = 6432\nunix_socket_dir = "
                            << folder_.string() << "\n";
    fs::permissions(settings,
                    fs::perms::owner_all | fs::perms::group_read | fs::perms::others_read);
    pooler_ = Run(kPooler, settings.string());
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    const std::string url = Url("postgres", "&port=6432");
    while (PQping(url.c_str()) != PQPING_OK) {
      INFO(TextOf(folder_ / "log"));
      REQUIRE(std::chrono::steady_clock::now() < latest);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  return Url(database, parameters);
}

std::string PostgresCluster::Url(const std::string& database, const std::string& parameters) const {
  return std::string("postgresql://") + kUser + "@/" + database + "?host=" + folder_.string() +
         parameters;
}

std::string PostgresCluster::Sql(const std::string& database, const std::string& script) const {
  PGconn* const connection = PQconnectdb(Url(database).c_str());
  PGresult* const result = PQexec(connection, script.c_str());
  const ExecStatusType status = PQresultStatus(result);
  const std::string error = PQerrorMessage(connection);
  const std::string value =
      status == PGRES_TUPLES_OK && PQntuples(result) > 0 ? PQgetvalue(result, 0, 0) : "";
  PQclear(result);
  PQfinish(connection);
  INFO(script << ": " << error);
  REQUIRE((status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK));
  return value;
}

namespace {

std::string NextName() {
  static std::atomic<int> count = 0;
  return "store" + std::to_string(++count);
}

}  // namespace

PostgresDatabase::PostgresDatabase(PostgresCluster& cluster)
    : cluster_(cluster), name_(NextName()) {
  cluster_.Sql("postgres", "CREATE DATABASE " + name_ + " TEMPLATE template0 ENCODING 'UTF8'");
}

PostgresDatabase::~PostgresDatabase() {
  // A failed test can have killed the cluster; a destructor must not throw.
  PGconn* const connection = PQconnectdb(cluster_.Url("postgres").c_str());
  PQclear(PQexec(connection, ("DROP DATABASE " + name_ + " WITH (FORCE)").c_str()));
  PQfinish(connection);
}

}  // namespace motiondb::tests
