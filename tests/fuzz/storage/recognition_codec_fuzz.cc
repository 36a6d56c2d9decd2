// The recognition part of a model. The first byte is the model's number of markers.
#include "storage/blob/model_codec.h"
#include "tests/fuzz/storage/codec_properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const Eigen::Index dimensions = 6 * (data[0] % 64);
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  (void)tests::CheckFieldCodec(
      bytes, [&](storage::FieldReader& reader) { return storage::GetMetric(reader, dimensions); },
      storage::PutMetric);
  (void)tests::CheckFieldCodec(
      bytes,
      [](storage::FieldReader& reader) {
        return storage::GetRecognition(reader, storage::StoredUnknown::kCurrent);
      },
      storage::PutRecognition);
  return 0;
}
