#include "storage/sqlite/sqlite_motion_store.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "core/motion/error.h"
#include "storage/sql/sql_motion_store_work.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/opening_check.h"
#include "storage/sqlite/store_disk.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

absl::StatusOr<std::unique_ptr<Writer>> StartWriter(std::unique_ptr<Connection> connection) {
  try {
    return std::make_unique<Writer>(std::move(connection));
  } catch (const std::system_error& error) {
    return absl::ResourceExhaustedError(
        fmt::format("cannot start the writer thread: {}", error.what()));
  }
}

// `file`: the identity of the file at `path`, which must not change.
std::unique_ptr<ReaderPool> MakeReaders(const std::string& path, FileIdentity file,
                                        ReaderPool::Open open, int limit) {
  return std::make_unique<ReaderPool>(
      std::move(open), [path, file] { return CheckFileIdentity(path, file); }, limit);
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteMotionStore>> SqliteMotionStore::Open(const std::string& path,
                                                                           SqliteOptions options) {
  if (path.empty()) return core::InvalidArgument("the path of the store must not be empty");
  if (path == ":memory:") {
    if (options.read_only) return core::InvalidArgument("a store in memory cannot be read-only");
    options.reserve_bytes = 0;
    MOTIONDB_ASSIGN_OR_RETURN(auto connection, OpenWriter(path, options.vfs));
    MOTIONDB_ASSIGN_OR_RETURN(auto writer, StartWriter(std::move(connection)));
    return std::unique_ptr<SqliteMotionStore>(new SqliteMotionStore(
        "", {}, std::nullopt, std::move(writer), nullptr, {}, std::move(options)));
  }
  // Resolve symbolic links, so that a file has one lock. Make the path absolute first: a missing
  // file would keep a relative path, and SQLite interprets a name that begins with "file:" as a
  // URI.
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  std::string file;
  if (!error) file = std::filesystem::weakly_canonical(absolute, error).string();
  if (error) return core::InvalidArgument("cannot open '{}': {}", path, error.message());
  MOTIONDB_RETURN_IF_ERROR(CheckIsStore(file));
  return options.read_only ? OpenReadOnly(std::move(file), std::move(options))
                           : OpenToWrite(std::move(file), std::move(options));
}

absl::StatusOr<std::unique_ptr<SqliteMotionStore>> SqliteMotionStore::OpenToWrite(
    std::string file, SqliteOptions options) {
  MOTIONDB_ASSIGN_OR_RETURN(StoreLock lock, StoreLock::Acquire(file));
  DeleteStaleCopies(file);
  OpeningCheck check = CheckBeforeOpening(file, /*read_only=*/false);
  MOTIONDB_ASSIGN_OR_RETURN(auto connection, OpenWriter(file, options.vfs));
  if (check.log_is_corrupt) CheckpointLog(*connection);
  Files files;
  MOTIONDB_ASSIGN_OR_RETURN(files.store, GetFileIdentity(file));
  // SQLite creates the log when the writer first reads, and keeps it until the writer is closed.
  MOTIONDB_ASSIGN_OR_RETURN(files.log, GetFileIdentity(LogPath(file)));
  auto readers = MakeReaders(
      file, files.store, [file, vfs = options.vfs] { return OpenReader(file, vfs); },
      options.reader_count);
  MOTIONDB_ASSIGN_OR_RETURN(auto writer, StartWriter(std::move(connection)));
  return std::unique_ptr<SqliteMotionStore>(
      new SqliteMotionStore(std::move(file), files, std::move(lock), std::move(writer),
                            std::move(readers), std::move(check.found), std::move(options)));
}

absl::StatusOr<std::unique_ptr<SqliteMotionStore>> SqliteMotionStore::OpenReadOnly(
    std::string file, SqliteOptions options) {
  Files files;
  MOTIONDB_ASSIGN_OR_RETURN(files.store, GetFileIdentity(file));
  MOTIONDB_ASSIGN_OR_RETURN(StoreLock lock, StoreLock::Acquire(file, StoreLock::Kind::kShared));
  OpeningCheck check = CheckBeforeOpening(file, /*read_only=*/true);
  const auto open = [file, is_short = check.is_short] { return OpenImmutable(file, is_short); };
  {
    MOTIONDB_ASSIGN_OR_RETURN(const auto reader, open());
    MOTIONDB_RETURN_IF_ERROR(CheckIsCurrentVersion(*reader));
  }
  auto readers = MakeReaders(file, files.store, open, options.reader_count);
  return std::unique_ptr<SqliteMotionStore>(
      new SqliteMotionStore(std::move(file), files, std::move(lock), nullptr, std::move(readers),
                            std::move(check.found), std::move(options)));
}

SqliteMotionStore::SqliteMotionStore(std::string path, Files files, std::optional<StoreLock> lock,
                                     std::unique_ptr<Writer> writer,
                                     std::unique_ptr<ReaderPool> readers,
                                     std::vector<Corruption> found_at_opening,
                                     SqliteOptions options)
    : SqlMotionStore(std::move(writer), std::move(readers), std::move(options.now_us)),
      path_(std::move(path)),
      files_(files),
      read_only_(options.read_only),
      found_at_opening_(std::move(found_at_opening)),
      reserve_(path_, options.reserve_bytes),
      lock_(std::move(lock)),
      on_index_rebuild_(std::move(options.on_index_rebuild)) {}

absl::StatusOr<std::vector<TextMatch>> SqliteMotionStore::SearchClips(const std::string& database,
                                                                      const std::string& query) {
  const auto search = [&] {
    return Read(
        [&](Connection& connection) { return SelectTextMatches(connection, database, query); });
  };
  if (!index_is_corrupt_ || read_only_) {
    auto matches = search();
    if (!IsOfSearchIndex(matches.status())) return matches;
    if (read_only_) {
      return core::DataLoss(
          "the search index is corrupt: {}; without --read-only, a search rebuilds it",
          std::string(matches.status().message()));
    }
    index_is_corrupt_ = true;
  }
  // Any write transaction rebuilds the index.
  const auto nothing = [](Connection&) { return absl::OkStatus(); };
  MOTIONDB_RETURN_IF_ERROR(Write(Priority::kOrdinary, nothing, ReadScope::cancelled()));
  return search();
}

bool SqliteMotionStore::MayRepair(const absl::Status& error) {
  if (!IsOfSearchIndex(error)) return false;
  index_is_corrupt_ = true;
  return true;
}

}  // namespace motiondb::storage
