#include "storage/sqlite/file_faults.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

constexpr std::int64_t kMaxFaults = 20;

// Returns a text of integrity_check without its lines about pages that are not used, which are not
// corrupt; empty if there is no other line.
std::string WithoutUnusedPages(std::string_view text) {
  constexpr std::string_view kTitle = "*** in database main ***";
  std::string rest;
  bool has_fault = false;
  while (!text.empty()) {
    const std::size_t size = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, size);
    text.remove_prefix(std::min(size + 1, text.size()));
    // "Page 7 is never used"; since SQLite 3.42 "Page 7: never used".
    if (line.starts_with("Page ") && line.ends_with(" never used")) continue;
    has_fault = has_fault || line != kTitle;
    rest += fmt::format("{}{}", rest.empty() ? "" : "\n", line);
  }
  return has_fault ? rest : "";
}

// Sets `faults` to those of an integrity check with a limit. Returns whether pages are not used.
absl::StatusOr<bool> CheckIntegrity(Connection& connection, std::int64_t limit,
                                    std::vector<std::string>& faults) {
  faults.clear();
  bool has_unused = false;
  Statement row = connection.Query(fmt::format("PRAGMA integrity_check({})", limit));
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return has_unused;
    const std::string text = row.Text(0);
    if (text == "ok") continue;
    std::string fault = WithoutUnusedPages(text);
    has_unused = has_unused || fault != text;
    if (!fault.empty() && std::ssize(faults) < kMaxFaults) faults.push_back(std::move(fault));
  }
}

}  // namespace

absl::Status FindFileFaults(Connection& connection, std::vector<std::string>& faults) {
  MOTIONDB_ASSIGN_OR_RETURN(const bool has_unused, CheckIntegrity(connection, kMaxFaults, faults));
  if (has_unused) {
    // Pages that a rebuild of the search index has left (RebuildClipText). SQLite counts them as
    // faults: look again for as many more.
    MOTIONDB_ASSIGN_OR_RETURN(const auto pages, connection.QueryInteger("PRAGMA page_count"));
    MOTIONDB_RETURN_IF_ERROR(CheckIntegrity(connection, pages + kMaxFaults, faults).status());
  }
  Statement reference = connection.Query("PRAGMA foreign_key_check");
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, reference.Step());
    if (!found) return absl::OkStatus();
    faults.push_back(fmt::format("row {} of table {} refers to a missing row of table {}",
                                 reference.Integer(1), reference.Text(0), reference.Text(2)));
  }
}

}  // namespace motiondb::storage
