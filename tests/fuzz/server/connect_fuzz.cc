// Bodies of the HTTP API. The first byte selects the reader of the rest: an envelope, gzip data, or
// JSON of a request, which must be equal after a conversion to protobuf and back.
#include "motiondb/v1/query.pb.h"
#include "server/gateway/connect_json.h"
#include "server/gateway/http_content.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

namespace {

constexpr std::int64_t kMaxBytes = 1 << 20;

void HoldsEnvelope(std::string_view body) {
  const auto envelope = server::ParseEnvelope(body);
  tests::CheckErrorContract(envelope.status(), absl::StatusCode::kInvalidArgument);
  if (!envelope.ok()) return;
  const std::uint8_t flags = envelope->compressed ? server::kCompressed : 0;
  tests::CheckContract(server::MakeEnvelope(flags, envelope->message) == body,
                       "an envelope round-trips");
}

void HoldsGzip(std::string_view bytes) {
  const auto admit = [](std::int64_t size) {
    return size <= kMaxBytes ? absl::OkStatus() : absl::InvalidArgumentError("too large");
  };
  const tests::MemoryWatch watch;
  const auto content = server::Gunzip(bytes, admit);
  watch.CheckProportional(0, 4 * kMaxBytes, 0);
  tests::CheckErrorContract(content.status(), absl::StatusCode::kInvalidArgument);
  const auto again = server::Gunzip(server::Gzip(bytes), admit);
  tests::CheckContract(again.ok() && *again == bytes, "compressed bytes come out again");
}

void HoldsJson(std::string_view json) {
  const google::protobuf::Descriptor& type = *v1::PredictRequest::descriptor();
  const auto bytes = server::ProtoFromJson(type, json);
  tests::CheckErrorContract(bytes.status(), absl::StatusCode::kInvalidArgument);
  if (!bytes.ok()) return;
  v1::PredictRequest request;
  if (!request.ParseFromString(*bytes)) return;  // repeated keys can exceed the depth
  const auto text = server::JsonFromProto(type, *bytes);
  tests::CheckContract(text.ok(), "a parsed request has JSON");
  const auto again = server::ProtoFromJson(type, *text);
  tests::CheckContract(again.ok(), "the JSON of a request is a request");
  v1::PredictRequest second;
  tests::CheckContract(
      second.ParseFromString(*again) && second.SerializeAsString() == request.SerializeAsString(),
      "a request round-trips");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view input = tests::AsText(data + 1, size - 1);
  switch (data[0] % 3) {
    case 0:
      HoldsEnvelope(input);
      break;
    case 1:
      HoldsGzip(input);
      break;
    default:
      HoldsJson(input);
      break;
  }
  return 0;
}
