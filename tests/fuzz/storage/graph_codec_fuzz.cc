// Transition graphs of a model. A decoded graph is traversed as in inference.
#include "storage/blob/model_codec.h"
#include "tests/fuzz/storage/codec_properties.h"

using namespace motiondb;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto graph = tests::CheckFieldCodec(bytes, storage::GetGraph, storage::PutGraph);
  (void)tests::CheckFieldCodec(bytes, storage::GetClipGraph, storage::PutClipGraph);
  if (!graph.ok()) return 0;
  for (int node = 0; node < graph->node_count(); ++node) {
    for (const core::Edge& edge : graph->row(node)) {
      tests::CheckContract(edge.to >= 0 && edge.to < graph->node_count(),
                           "an edge leads to a node");
      tests::CheckContract(edge.count > 0, "an edge has a count");
    }
  }
  return 0;
}
