#include <catch2/catch.hpp>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/message_fields.h"

namespace motiondb::tests::field_text_test {
namespace {

TEST_CASE("FieldText: the text at a path, empty if the path does not exist", "[server]") {
  v1::IngestClipRequest request;
  CHECK(server::FieldText(request, "header.parent").empty());
  request.mutable_header()->set_parent("databases/walks");
  CHECK(server::FieldText(request, "header.parent") == "databases/walks");
  CHECK(server::FieldText(request, "").empty());
  request.set_file_block("x");  // the other part of the oneof
  CHECK(server::FieldText(request, "header.parent").empty());
}

TEST_CASE("FindTextField: accepts only a single string", "[server]") {
  const auto has = [](const char* path) {
    return server::FindTextField(*v1::PredictSeriesRequest::descriptor(), path) != nullptr;
  };
  CHECK(has("prediction.database"));
  CHECK(!has("prediction"));
  CHECK(!has("prediction.horizon_seconds"));
  CHECK(!has("prediction.none"));
  CHECK(!has("every_seconds"));
  CHECK(!has("every_seconds.database"));
  CHECK(!has(""));
}

}  // namespace
}  // namespace motiondb::tests::field_text_test
