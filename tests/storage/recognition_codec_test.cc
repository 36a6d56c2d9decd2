#include <catch2/catch.hpp>

#include "storage/blob/model_codec.h"

namespace motiondb::tests::recognition_codec_test {
namespace {

TEST_CASE("Metric: directions without dimensions are data loss", "[storage][hostile]") {
  storage::StringSink sink;
  storage::FieldWriter writer(sink);
  writer.PutCount(3);  // directions
  writer.PutCount(2);  // loadings
  writer.Put(1.0);     // noise; the matrices have no numbers
  REQUIRE(writer.status().ok());
  storage::SpanSource source(std::as_bytes(std::span(sink.bytes())));
  storage::FieldReader reader(source);
  storage::GetMetric(reader, 0);
  CHECK(reader.Finish().code() == absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace motiondb::tests::recognition_codec_test
