// Marker-set files: writing and reading a parsed file preserves its text.
#include "core/format/marker_set_file.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const tests::MemoryWatch watch;
  const auto scheme = core::ReadMarkerSetFile({"input.markers", tests::AsText(data, size)});
  watch.CheckProportional(size, 1 << 20, 200);
  tests::CheckErrorContract(scheme.status(), absl::StatusCode::kInvalidArgument);
  if (!scheme.ok()) return 0;

  for (const core::MarkerMapping& mapping : scheme->mappings) {
    tests::CheckContract(mapping.rules.size() == scheme->set.markers.size(),
                         "a mapping has one rule per marker");
  }
  const std::string text = core::WriteMarkerSetFile(*scheme);
  const auto again = core::ReadMarkerSetFile({"written.markers", text});
  tests::CheckContract(again.ok(), "a written marker set can be read");
  tests::CheckContract(core::WriteMarkerSetFile(*again) == text,
                       "a written marker set is preserved");
  return 0;
}
