// Annotations as TSV.
#include "tests/fuzz/client/annotation_properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tests::CheckAnnotationReader(client::AnnotationFormat::kTsv, data, size);
  return 0;
}
