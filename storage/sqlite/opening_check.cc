#include "storage/sqlite/opening_check.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "storage/sqlite/big_endian.h"
#include "storage/sqlite/log_reader.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

namespace fs = std::filesystem;

std::string Describe(const LogContent& log, const std::string& path) {
  const std::string where =
      log.bad_frame == 0 ? "its header" : fmt::format("its frame {}", log.bad_frame);
  return fmt::format(
      "the log '{}' is corrupt at {}: SQLite drops {} valid frames after it, with {} complete "
      "transactions; acknowledged changes may be missing",
      path, where, log.lost_frames, log.lost_transactions);
}

void CheckLog(const std::string& store_path, std::uint32_t page_bytes, bool read_only,
              OpeningCheck& check, LogContent& log) {
  const std::string path = LogPath(store_path);
  const std::string kept_path = store_path + "-corrupt-wal";
  log = ReadLog(path, page_bytes);
  check.log_is_corrupt = log.is_corrupt;
  std::error_code error;
  if (log.is_corrupt && !read_only) {
    fs::copy_file(path, kept_path, fs::copy_options::overwrite_existing, error);
  }
  const LogContent kept = ReadLog(kept_path, page_bytes);
  if (kept.is_corrupt && !error) {
    check.found.push_back(
        {"", fmt::format("{}; ingest missing clips again or restore a backup, then delete '{}', "
                         "the copy of that log",
                         Describe(kept, path), kept_path)});
  } else if (log.is_corrupt) {
    check.found.push_back({"", Describe(log, path)});
  }
}

// Checks whether the file was truncated. REQUIRES: recovery finds nothing in the log.
void CheckLength(const std::string& path, std::string_view header, std::int64_t page_bytes,
                 bool read_only, OpeningCheck& check) {
  // SQLite ignores the page count if the last writer did not update it.
  constexpr std::size_t kChangeCounter = 24;
  constexpr std::size_t kPageCount = 28;
  constexpr std::size_t kCountIsOfChange = 92;
  if (BigEndian(header, kChangeCounter) != BigEndian(header, kCountIsOfChange)) return;
  std::error_code error;
  // Creation of the store was interrupted: SQLite rolls it back.
  if (fs::exists(path + "-journal", error)) return;
  const auto bytes = static_cast<std::int64_t>(fs::file_size(path, error));
  const std::int64_t expected = BigEndian(header, kPageCount) * page_bytes;
  if (error || bytes < page_bytes || bytes >= expected) return;
  check.found.push_back(
      {"", fmt::format("the file '{}' was truncated: expected {} bytes, got {}; the data on its "
                       "last {} pages is lost: restore a backup",
                       path, expected, bytes, (expected - bytes + page_bytes - 1) / page_bytes)});
  if (!read_only) fs::resize_file(path, static_cast<std::uintmax_t>(expected), error);
  check.is_short = read_only || error;
}

}  // namespace

OpeningCheck CheckBeforeOpening(const std::string& store_path, bool read_only) {
  OpeningCheck check;
  std::string header(kStoreHeaderBytes, '\0');
  std::ifstream stream(store_path, std::ios::binary);
  if (!stream.read(header.data(), static_cast<std::streamsize>(header.size()))) return check;
  const std::uint32_t field = BigEndian(header, 14) & 0xffff;
  const std::uint32_t page_bytes = field == 1 ? 65536 : field;
  LogContent log;
  CheckLog(store_path, page_bytes, read_only, check, log);
  if (log.page_count == 0) CheckLength(store_path, header, page_bytes, read_only, check);
  return check;
}

}  // namespace motiondb::storage
