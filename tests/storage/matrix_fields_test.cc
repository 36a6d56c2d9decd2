#include <catch2/catch.hpp>

#include "core/motion/matrix.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::tests::matrix_fields_test {
namespace {

TEST_CASE("Matrix fields: sizes with an overflowing product are data loss", "[storage][hostile]") {
  const std::string bytes(64, '\0');
  // 2^31 x 2^33 floats are 2^66 bytes: 0 in 64 bits.
  for (const auto& [rows, columns] : {std::pair<Eigen::Index, Eigen::Index>{1L << 31, 1L << 33},
                                      {1L << 62, 4},
                                      {17, 1},
                                      {4, 5}}) {
    storage::SpanSource source(std::as_bytes(std::span(bytes)));
    storage::FieldReader reader(source);
    core::FrameMatrix matrix;
    storage::GetMatrix(reader, rows, columns, matrix);
    CHECK(reader.status().code() == absl::StatusCode::kDataLoss);
    CHECK(matrix.size() == 0);
  }
  storage::SpanSource source(std::as_bytes(std::span(bytes)));
  storage::FieldReader reader(source);
  core::FrameMatrix matrix;
  storage::GetMatrix(reader, 4, 4, matrix);
  CHECK(reader.Finish().ok());
  CHECK(matrix.rows() == 4);
}

}  // namespace
}  // namespace motiondb::tests::matrix_fields_test
