// Models. A decoded model is joined with synthetic states, as in the store.
#include "storage/blob/model_codec.h"
#include "storage/blob/newer_format.h"
#include "tests/fuzz/storage/codec_properties.h"

using namespace motiondb;

namespace {

constexpr std::uint32_t kEncodedVersion = 5;
constexpr std::int64_t kMaxNumbers = 1 << 20;  // of synthetic states

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const tests::MemoryWatch watch;
  storage::SpanSource source(bytes);
  auto parts = storage::DecodeModel(source);
  watch.CheckProportional(size, tests::kDecodingBase, tests::kDecodingFactor);
  if (storage::IsNewerFormat(parts.status())) return 0;
  tests::CheckErrorContract(parts.status(), absl::StatusCode::kDataLoss);
  if (!parts.ok()) return 0;
  if (data[0] == kEncodedVersion) {
    storage::StringSink sink;
    tests::CheckContract(storage::EncodeModel(*parts, sink).ok(), "a decoded value can be encoded");
    tests::CheckSameBytes(sink, bytes);
  }

  const std::int64_t frames = parts->tree.frame_count();
  const std::int64_t dimensions = parts->marker_set.dimension_count();
  if (frames * dimensions > kMaxNumbers || frames > kMaxNumbers) return 0;
  parts->states = core::SharedRows(core::FrameMatrix::Zero(frames, dimensions));
  parts->root_path = core::RootPath::Zero(frames, 3);
  const auto model = core::Model::Create(*std::move(parts));
  tests::CheckErrorContract(model.status(), absl::StatusCode::kDataLoss);
  return 0;
}
