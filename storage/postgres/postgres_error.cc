#include "storage/postgres/postgres_error.h"

#include <array>
#include <string>
#include <utility>

#include "absl/strings/cord.h"
#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

constexpr char kConflictUrl[] = "motiondb.postgres.conflict";

using absl::StatusCode;

// Codes by the beginning of the SQLSTATE, the first that fits:
// https://www.postgresql.org/docs/15/errcodes-appendix.html
constexpr std::array<std::pair<std::string_view, StatusCode>, 20> kCodes{{
    {"23505", StatusCode::kAlreadyExists},      // unique_violation
    {"40001", StatusCode::kAborted},            // serialization_failure
    {"40P01", StatusCode::kAborted},            // deadlock_detected
    {"22021", StatusCode::kInvalidArgument},    // character_not_in_repertoire
    {"22P05", StatusCode::kInvalidArgument},    // untranslatable_character
    {"54", StatusCode::kInvalidArgument},       // program_limit_exceeded: a value is too large
    {"53", StatusCode::kResourceExhausted},     // insufficient_resources: disk_full, out_of_memory
    {"XX001", StatusCode::kDataLoss},           // data_corrupted
    {"XX002", StatusCode::kDataLoss},           // index_corrupted
    {"08", StatusCode::kUnavailable},           // connection_exception
    {"57P01", StatusCode::kUnavailable},        // admin_shutdown
    {"57P02", StatusCode::kUnavailable},        // crash_shutdown
    {"57P03", StatusCode::kUnavailable},        // cannot_connect_now
    {"57014", StatusCode::kUnavailable},        // query_canceled: statement_timeout
    {"55P03", StatusCode::kUnavailable},        // lock_not_available: lock_timeout
    {"25006", StatusCode::kUnavailable},        // read_only_sql_transaction: a standby
    {"0A000", StatusCode::kUnavailable},        // feature_not_supported: write on a standby
    {"25P03", StatusCode::kUnavailable},        // idle_in_transaction_session_timeout
    {"58", StatusCode::kUnavailable},           // system_error: io_error
    {"42501", StatusCode::kFailedPrecondition}  // insufficient_privilege
}};

StatusCode CodeOf(std::string_view sqlstate) {
  for (const auto& [beginning, code] : kCodes) {
    if (sqlstate.starts_with(beginning)) return code;
  }
  return StatusCode::kInternal;
}

// Without the line feed that libpq adds.
std::string Trimmed(std::string_view message) {
  while (!message.empty() && message.back() == '\n') message.remove_suffix(1);
  return std::string(message);
}

}  // namespace

absl::Status PostgresError(std::string_view sqlstate, std::string_view message) {
  absl::Status error(CodeOf(sqlstate),
                     fmt::format("PostgreSQL: {} (SQLSTATE {})", Trimmed(message), sqlstate));
  if (error.code() == StatusCode::kAborted) error.SetPayload(kConflictUrl, absl::Cord("1"));
  return error;
}

absl::Status PostgresError(PGconn* connection, const PGresult* result) {
  const char* const sqlstate =
      result == nullptr ? nullptr : PQresultErrorField(result, PG_DIAG_SQLSTATE);
  if (sqlstate != nullptr) {
    // The primary message alone: the detail can contain values of rows.
    const char* const primary = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
    return PostgresError(sqlstate, primary == nullptr ? "no message" : primary);
  }
  return absl::UnavailableError(fmt::format("PostgreSQL: {}", Trimmed(PQerrorMessage(connection))));
}

bool IsConflict(const absl::Status& error) { return error.GetPayload(kConflictUrl).has_value(); }

}  // namespace motiondb::storage
