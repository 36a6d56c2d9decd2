#include "storage/postgres/postgres_statement.h"

#include <bit>
#include <limits>
#include <utility>

#include "core/motion/error.h"
#include "storage/postgres/postgres_connection.h"
#include "storage/postgres/postgres_conversion.h"

namespace motiondb::storage {
namespace {

// Object ids of types, which never change (PostgreSQL's pg_type.dat).
constexpr Oid kBool = 16;
constexpr Oid kBytea = 17;
constexpr Oid kInt8 = 20;
constexpr Oid kInt2 = 21;
constexpr Oid kInt4 = 23;
constexpr Oid kText = 25;
constexpr Oid kFloat8 = 701;
constexpr Oid kName = 19;
constexpr Oid kVoid = 2278;

// INTERNAL if a column has a type that the statement cannot read, such as the sum of integers,
// which is numeric.
absl::Status CheckTypes(const PGresult* result) {
  for (int column = 0; column < PQnfields(result); ++column) {
    switch (const Oid type = PQftype(result, column)) {
      case kBool:
      case kBytea:
      case kInt8:
      case kInt2:
      case kInt4:
      case kText:
      case kFloat8:
      case kName:
      case kVoid:
        break;
      default:
        return absl::InternalError(
            fmt::format("PostgreSQL: column {} has the unexpected type {}", column, type));
    }
  }
  return absl::OkStatus();
}

// Numbers have the network byte order.
std::string ToBytes(std::uint64_t value) {
  std::string bytes(sizeof(value), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<char>(value >> (8 * (bytes.size() - 1 - i)));
  }
  return bytes;
}

std::uint64_t ToNumber(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char byte : bytes) value = (value << 8) | static_cast<std::uint8_t>(byte);
  return value;
}

}  // namespace

void PostgresStatement::Add(Oid type, const char* bytes, std::size_t size) {
  parameters_.types.push_back(type);
  parameters_.values.push_back(bytes);
  parameters_.lengths.push_back(static_cast<int>(size));
  parameters_.formats.push_back(1);
}

std::string_view PostgresStatement::Keep(std::string bytes) {
  return kept_.emplace_back(std::move(bytes));
}

void PostgresStatement::BindInteger(std::int64_t value) {
  const std::string_view bytes = Keep(ToBytes(static_cast<std::uint64_t>(value)));
  Add(kInt8, bytes.data(), bytes.size());
}

void PostgresStatement::BindReal(double value) {
  const std::string_view bytes = Keep(ToBytes(std::bit_cast<std::uint64_t>(value)));
  Add(kFloat8, bytes.data(), bytes.size());
}

void PostgresStatement::BindText(std::string_view text) {
  const std::string_view bytes = Keep(ToPostgresText(text));
  Add(kText, bytes.data(), bytes.size());
}

void PostgresStatement::BindBlob(std::span<const std::byte> blob) {
  // A null pointer would be NULL.
  Add(kBytea, blob.empty() ? "" : reinterpret_cast<const char*>(blob.data()), blob.size());
}

void PostgresStatement::BindNull() { Add(0, nullptr, 0); }

absl::StatusOr<bool> PostgresStatement::StepStream() {
  if (!is_streaming_) {
    if (result_ != nullptr) return false;  // after the last row
    MOTIONDB_RETURN_IF_ERROR(connection_.Send(*this));
    is_streaming_ = true;
  }
  auto row = connection_.NextRow();
  is_streaming_ = row.ok() && PQresultStatus(row->get()) == PGRES_SINGLE_TUPLE;
  MOTIONDB_RETURN_IF_ERROR(row.status());
  MOTIONDB_RETURN_IF_ERROR(CheckTypes(row->get()));
  result_ = *std::move(row);
  row_ = 0;
  return is_streaming_;
}

absl::StatusOr<bool> PostgresStatement::Step() {
  if (rows_ == Rows::kStream) return StepStream();
  if (result_ == nullptr) {
    MOTIONDB_ASSIGN_OR_RETURN(ResultHandle result, connection_.Run(*this));
    MOTIONDB_RETURN_IF_ERROR(CheckTypes(result.get()));
    result_ = std::move(result);
    row_ = -1;
  }
  if (row_ + 1 >= PQntuples(result_.get())) return false;
  ++row_;
  return true;
}

absl::StatusOr<bool> PostgresStatement::Queue() { return connection_.Queue(*this); }

void PostgresStatement::Reset() {
  if (std::exchange(is_streaming_, false)) connection_.StopRows();
  parameters_ = {};
  kept_.clear();
  result_.reset();
  row_ = -1;
}

std::string_view PostgresStatement::Bytes(int column) const {
  return {PQgetvalue(result_.get(), row_, column),
          static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
}

bool PostgresStatement::IsNull(int column) const {
  return PQgetisnull(result_.get(), row_, column) != 0;
}

ColumnType PostgresStatement::Type(int column) const {
  if (IsNull(column)) return ColumnType::kNull;
  switch (PQftype(result_.get(), column)) {
    case kBytea:
      return ColumnType::kBlob;
    case kFloat8:
      return ColumnType::kReal;
    case kText:
    case kName:
      return ColumnType::kText;
    case kVoid:
      return ColumnType::kNull;
    default:
      return ColumnType::kInteger;
  }
}

std::int64_t PostgresStatement::Integer(int column) const {
  if (IsNull(column)) return 0;
  const std::uint64_t value = ToNumber(Bytes(column));
  switch (PQftype(result_.get(), column)) {
    case kBool:
    case kInt8:
      return static_cast<std::int64_t>(value);
    case kInt4:
      return static_cast<std::int32_t>(value);
    case kInt2:
      return static_cast<std::int16_t>(value);
    case kFloat8:
      return static_cast<std::int64_t>(std::bit_cast<double>(value));
    default:
      return 0;
  }
}

double PostgresStatement::Real(int column) const {
  if (IsNull(column)) return 0;
  if (PQftype(result_.get(), column) != kFloat8) return static_cast<double>(Integer(column));
  return std::bit_cast<double>(ToNumber(Bytes(column)));
}

std::string PostgresStatement::Text(int column) const {
  if (IsNull(column)) return "";
  switch (PQftype(result_.get(), column)) {
    case kInt8:
    case kInt4:
    case kInt2:
      return std::to_string(Integer(column));
    default:
      return FromPostgresText(Bytes(column));
  }
}

std::span<const std::byte> PostgresStatement::Blob(int column) const {
  const std::string_view bytes = Bytes(column);
  return std::as_bytes(std::span(bytes.data(), bytes.size()));
}

}  // namespace motiondb::storage
