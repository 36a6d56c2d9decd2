#include "storage/postgres/postgres_conversion.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "absl/strings/cord.h"
#include "core/motion/error.h"
#include "text/utf8.h"

namespace motiondb::storage {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string ToPostgresSql(std::string_view sql) {
  std::string translated;
  int last = 0;
  char quote = 0;  // of the text that is being read; 0: none
  for (std::size_t i = 0; i < sql.size(); ++i) {
    const char c = sql[i];
    if (quote != 0) {
      if (c == quote) quote = 0;  // a doubled quote begins the next text
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '?') {
      int number = 0;
      for (; i + 1 < sql.size() && IsDigit(sql[i + 1]); ++i)
        number = 10 * number + sql[i + 1] - '0';
      if (number == 0) number = last + 1;
      last = std::max(last, number);
      translated += "$" + std::to_string(number);
      continue;
    }
    translated += c;
  }
  return translated;
}

namespace {

constexpr char kEscape = '\x01';
constexpr std::string_view kDigits = "0123456789abcdef";

unsigned ByteAt(std::string_view bytes, std::size_t place) {
  return place < bytes.size() ? static_cast<unsigned char>(bytes[place]) : 0;
}

}  // namespace

std::string ToPostgresText(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  while (!bytes.empty()) {
    std::size_t length = text::FirstCharacter(bytes).bytes;
    if (length == 0) {
      length = 1;
      const unsigned byte = ByteAt(bytes, 0);
      text += {kEscape, '2', kDigits[byte >> 4], kDigits[byte & 15]};
    } else if (bytes[0] == '\0' || bytes[0] == kEscape) {
      text += {kEscape, bytes[0] == '\0' ? '0' : '1'};
    } else {
      text += bytes.substr(0, length);
    }
    bytes.remove_prefix(length);
  }
  return text;
}

std::string FromPostgresText(std::string_view text) {
  if (text.find(kEscape) == std::string_view::npos) return std::string(text);
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != kEscape) {
      bytes += text[i];
      continue;
    }
    const unsigned kind = ByteAt(text, ++i);
    if (kind == '2') {
      const std::size_t high = kDigits.find(static_cast<char>(ByteAt(text, i + 1)));
      const std::size_t low = kDigits.find(static_cast<char>(ByteAt(text, i + 2)));
      bytes += static_cast<char>(((high & 15) << 4) | (low & 15));
      i += 2;
    } else {
      bytes += kind == '0' ? '\0' : kEscape;
    }
  }
  return bytes;
}

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
