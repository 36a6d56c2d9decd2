// Skeleton blobs.
#include "storage/blob/clip_codec.h"
#include "tests/fuzz/storage/codec_properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)tests::CheckCodec(std::as_bytes(std::span(data, size)), storage::DecodeSkeleton,
                          storage::EncodeSkeleton);
  return 0;
}
