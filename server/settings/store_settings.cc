#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "server/settings/groups.h"
#include "storage/store_url.h"

namespace motiondb::server {
namespace {

constexpr Words<ServerWork, 3> kWork{
    {{"both", ServerWork::kBoth}, {"serve", ServerWork::kServe}, {"build", ServerWork::kBuild}}};

}  // namespace

void AddStoreSettings(CLI::App& app, Settings& settings) {
  app.add_option(
         "--store", settings.store_path,
         "File of the store with all databases; created if absent. Or postgresql://USER@HOST/NAME, "
         "as libpq takes it: a PostgreSQL database")
      ->type_name("FILE")
      ->group("Store");
  app.add_flag("--read-only", settings.read_only,
               "Answer queries and refuse all changes; the store may be on a read-only file system")
      ->group("Store");
  AddMebibytes(app, "--disk-reserve-mib", settings.disk_reserve_bytes,
               "Free disk space that clips, models and restores must leave, so that data can "
               "still be deleted when the disk is full; 0: none",
               1 << 20, 0)
      ->group("Store");
}

void CheckStoreSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  namespace fs = std::filesystem;
  if (settings.store_path.empty()) return;                  // reported where settings are read
  if (storage::IsPostgresUrl(settings.store_path)) return;  // a start connects
  const auto require = [&](const fs::path& path, const char* purpose, int rights) {
    if (access(path.c_str(), rights) == 0) return;
    problems.push_back(absl::FailedPreconditionError(
        fmt::format("store: {} {}: {}", purpose, path.string(), std::strerror(errno))));
  };
  const fs::path store(settings.store_path);
  std::error_code ignored;
  if (fs::is_directory(store, ignored)) {
    problems.push_back(absl::InvalidArgumentError(
        fmt::format("store: expected the path of a file, got the folder {}", store.string())));
    return;
  }
  if (settings.read_only) return require(store, "cannot read", R_OK);
  // SQLite writes its log in the folder of the file.
  require(store.has_parent_path() ? store.parent_path() : fs::path("."), "cannot write to folder",
          R_OK | W_OK);
  if (fs::exists(store, ignored)) require(store, "cannot read and write", R_OK | W_OK);
}

void AddEngineSettings(CLI::App& app, Settings& settings) {
  EngineOptions& engine = settings.server.engine;
  AddCount(app, "--threads", engine.query_threads, 0, 1024, "Threads for requests; 0: one per core")
      ->group("Engine");
  AddCount(app, "--build-threads", engine.build_threads, 0, 1024,
           "Threads for building models; 0: one per two cores")
      ->group("Engine");
  AddSeconds(
      app, "--rebuild-delay", engine.rebuild_delay, 0, 3600,
      "Time without an ingest after which the model is rebuilt. The rebuild starts at most 10 s "
      "(or this time, if longer) after the first ingest")
      ->group("Engine");
  AddWord(app, "--work", engine.work, kWork,
          "Work of this server, if several servers share a store: serve answers and leaves all "
          "builds to the others; build keeps only the model in memory that it built last")
      ->group("Engine");
  AddMebibytes(app, "--model-memory", engine.model_memory_bytes,
               "Memory for models. Models are then read when they are first used, and evicted if "
               "they were not used for the longest time; 0: all models stay in memory",
               1 << 30, 0)
      ->group("Engine");
}

void CheckEngineSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  if (settings.server.engine.work == ServerWork::kBoth) return;
  if (storage::IsPostgresUrl(settings.store_path)) return;
  problems.push_back(absl::InvalidArgumentError(
      "work: expected both, because the only server of a file serves and builds; servers share the "
      "work on a store in PostgreSQL"));
}

}  // namespace motiondb::server
