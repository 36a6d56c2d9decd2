// Motion from motiondb-import, whose reader may have been taken over by a malicious file.
#include "storage/blob/motion_codec.h"
#include "tests/fuzz/storage/codec_properties.h"
#include "tests/fuzz/support/motion_properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto decoded = tests::CheckCodec(std::as_bytes(std::span(data, size)),
                                         storage::DecodeMotion, storage::EncodeMotion);
  // Ingest treats it as the result of a reader.
  if (decoded.ok()) tests::CheckMotionFile(decoded);
  return 0;
}
