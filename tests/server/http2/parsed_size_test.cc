// Compares with the memory of the message after protobuf has parsed it.
#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/http2/grpc_wire.h"

namespace motiondb::tests::parsed_size_test {
namespace {

std::int64_t Estimate(const google::protobuf::Message& like, const std::string& bytes) {
  return server::ParsedSize(*like.GetDescriptor(),
                            {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

// The estimate is an upper bound, and not many times the memory of the parsed message.
template <typename Message>
void CheckEstimate(const std::string& bytes) {
  Message message;
  message.ParseFromString(bytes);
  const auto taken = static_cast<std::int64_t>(message.SpaceUsedLong());
  const std::int64_t estimate = Estimate(message, bytes);
  CHECK(estimate >= taken);
  CHECK(estimate <= 4 * taken + 32 * static_cast<std::int64_t>(bytes.size()) + 1024);
}

TEST_CASE("FindRpc: finds a call by its path", "[server][http2]") {
  const auto* const recognize = server::FindRpc("/motiondb.v1.QueryService/Recognize");
  REQUIRE(recognize != nullptr);
  CHECK(recognize->input_type() == v1::RecognizeRequest::descriptor());
  for (const char* const unknown : {"", "/", "/motiondb.v1.QueryService", "/no.such/Method", "x"}) {
    CHECK(server::FindRpc(unknown) == nullptr);
  }
}

TEST_CASE("ParsedSize: many small parts need many times their bytes", "[server][http2]") {
  v1::Obstacles discs;
  for (int i = 0; i < 100'000; ++i) discs.add_discs();
  const std::string bytes = discs.SerializeAsString();
  CHECK(bytes.size() == 200'000);
  CHECK(Estimate(discs, bytes) > 4'000'000);
  CheckEstimate<v1::Obstacles>(bytes);
  v1::Obstacles polygons;
  for (int i = 0; i < 1000; ++i) {
    auto& polygon = *polygons.add_polygons();
    for (int j = 0; j < 20; ++j) polygon.add_corners()->set_x_m(j);
  }
  CheckEstimate<v1::Obstacles>(polygons.SerializeAsString());
}

TEST_CASE("ParsedSize: large fields, packed numbers and texts", "[server][http2]") {
  v1::RecognizeRequest recognize;
  recognize.mutable_observation()->mutable_file()->set_data(std::string(1 << 20, 'x'));
  CheckEstimate<v1::RecognizeRequest>(recognize.SerializeAsString());
  v1::ObserveRequest observe;
  for (int i = 0; i < 10'000; ++i) observe.mutable_start()->add_horizon_seconds(i);
  for (int i = 0; i < 10'000; ++i) observe.mutable_start()->add_marker_names("");
  CheckEstimate<v1::ObserveRequest>(observe.SerializeAsString());
}

TEST_CASE("ParsedSize: entries of maps", "[server][http2]") {
  v1::UploadClipRequest upload;
  for (int i = 0; i < 64; ++i) {
    auto& field = (*upload.mutable_header()->mutable_fields())["field" + std::to_string(i)];
    if (i % 2 == 0) {
      field.set_text(std::string(i, 'x'));
    } else {
      field.set_number(i);
    }
  }
  CheckEstimate<v1::UploadClipRequest>(upload.SerializeAsString());
}

TEST_CASE("ParsedSize: unknown fields, and bytes that are no message", "[server][http2]") {
  std::string unknown;
  for (int i = 0; i < 10'000; ++i) unknown += std::string("\xfa\x3f\x00", 3);  // field 1023, empty
  CheckEstimate<v1::RecognizeRequest>(unknown);
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string bytes(random() % 300, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    CheckEstimate<v1::ObserveRequest>(bytes);
  }
  // Nested deeper than protobuf's limit.
  std::string nested;
  for (int i = 0; i < 100'000; ++i) nested += "\x0b";  // groups that never end
  CHECK(Estimate(v1::ObserveRequest(), nested) >= 0);
}

}  // namespace
}  // namespace motiondb::tests::parsed_size_test
