// Models. What decodes is put together with states that fit it, as the store does.
#include "storage/blob/model_codec.h"
#include "tests/fuzz/storage/codec_properties.h"

using namespace motiondb;

namespace {

constexpr std::uint32_t kEncodedVersion = 3;
constexpr std::int64_t kMostNumbers = 1 << 20;  // of states that are made up

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const tests::MemoryWatch watch;
  storage::SpanSource source(bytes);
  auto parts = storage::DecodeModel(source);
  watch.HoldsProportional(size, tests::kDecodingBase, tests::kDecodingFactor);
  tests::HoldsError(parts.status(), absl::StatusCode::kDataLoss);
  if (!parts.ok()) return 0;
  if (data[0] == kEncodedVersion) {
    storage::StringSink sink;
    tests::Holds(storage::EncodeModel(*parts, sink).ok(), "what was decoded can be encoded");
    tests::HoldsSameBytes(sink, bytes);
  }

  const std::int64_t frames = parts->tree.frame_count();
  const std::int64_t dimensions = parts->marker_set.dimension_count();
  if (frames * dimensions > kMostNumbers || frames > kMostNumbers) return 0;
  parts->states = core::SharedRows(core::FrameMatrix::Zero(frames, dimensions));
  parts->root_path = core::RootPath::Zero(frames, 3);
  const auto model = core::Model::Create(*std::move(parts));
  tests::HoldsError(model.status(), absl::StatusCode::kDataLoss);
  return 0;
}
