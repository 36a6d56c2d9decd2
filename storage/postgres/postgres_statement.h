// A statement for PostgreSQL: keeps its parameters, runs at the first Step, and then has all its
// rows, or, of a stream, one after another. Parameters and results have the binary format.
#pragma once

#include <libpq-fe.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sql/connection/statement.h"

namespace motiondb::storage {

class PostgresConnection;

struct FreeResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
using ResultHandle = std::unique_ptr<PGresult, FreeResult>;

// The parameters of a statement as libpq takes them.
struct PostgresParameters {
  std::vector<Oid> types;  // 0: NULL, whose type PostgreSQL infers
  std::vector<const char*> values;
  std::vector<int> lengths;
  std::vector<int> formats;
};

class PostgresStatement final : public PreparedStatement {
 public:
  enum class Rows { kAll, kStream };
  // `sql`: translated (ToPostgresSql). The connection must outlive the object.
  PostgresStatement(PostgresConnection& connection, const std::string& sql, Rows rows)
      : connection_(connection), sql_(sql), rows_(rows) {}

  void BindInteger(std::int64_t value) override;
  void BindReal(double value) override;
  void BindText(std::string_view text) override;  // copied
  void BindBlob(std::span<const std::byte> blob) override;
  void BindNull() override;

  absl::StatusOr<bool> Step() override;
  absl::StatusOr<bool> Queue() override;
  void Reset() override;

  std::int64_t Integer(int column) const override;
  double Real(int column) const override;
  std::string Text(int column) const override;
  std::span<const std::byte> Blob(int column) const override;
  ColumnType Type(int column) const override;

  const std::string& sql() const { return sql_; }
  const PostgresParameters& parameters() const { return parameters_; }

 private:
  absl::StatusOr<bool> StepStream();
  bool IsNull(int column) const;
  // `bytes` must outlive the statement or its next Reset.
  void Add(Oid type, const char* bytes, std::size_t size);
  // Returns a copy of the bytes that lives until the next Reset.
  std::string_view Keep(std::string bytes);
  std::string_view Bytes(int column) const;

  PostgresConnection& connection_;
  const std::string sql_;
  const Rows rows_;
  bool is_streaming_ = false;  // rows may follow
  PostgresParameters parameters_;
  std::deque<std::string> kept_;  // a deque: its elements do not move
  ResultHandle result_;           // null before the first Step
  int row_ = -1;
};

}  // namespace motiondb::storage
