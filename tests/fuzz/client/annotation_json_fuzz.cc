// Annotations as JSON.
#include "tests/fuzz/client/annotation_properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tests::CheckAnnotationReader(client::AnnotationFormat::kJson, data, size);
  return 0;
}
