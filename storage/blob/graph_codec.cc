#include "storage/blob/graph_codec.h"

#include <utility>

namespace motiondb::storage {
namespace {

using core::Edge;

static_assert(sizeof(Edge) == 8, "edges are stored as they lie in memory");

bool RowsFit(const std::vector<std::int32_t>& row_begin, std::size_t edge_count) {
  if (row_begin.empty() || row_begin.front() != 0) return false;
  for (std::size_t k = 1; k < row_begin.size(); ++k) {
    if (row_begin[k] < row_begin[k - 1]) return false;
  }
  return static_cast<std::size_t>(row_begin.back()) == edge_count;
}

// Edges of each row ascend and lead to nodes that there are.
bool EdgesFit(const std::vector<std::int32_t>& row_begin, const std::vector<Edge>& edges) {
  const auto node_count = static_cast<std::int32_t>(row_begin.size()) - 1;
  for (std::int32_t k = 0; k < node_count; ++k) {
    std::int32_t before = -1;
    for (std::int32_t e = row_begin[k]; e < row_begin[k + 1]; ++e) {
      if (edges[e].to <= before || edges[e].to >= node_count || edges[e].count <= 0) return false;
      before = edges[e].to;
    }
  }
  return true;
}

}  // namespace

void PutGraph(FieldWriter& writer, const core::TransitionGraph& graph) {
  writer.PutArray(graph.row_begin());
  writer.PutArray(graph.edges());
}

core::TransitionGraph GetGraph(FieldReader& reader) {
  auto row_begin = reader.GetArray<std::int32_t>();
  auto edges = reader.GetArray<Edge>();
  if (!reader.ok()) return {};
  if (!RowsFit(row_begin, edges.size()) || !EdgesFit(row_begin, edges)) {
    reader.Fail(core::DataLoss("a transition graph has edges that are not in order"));
    return {};
  }
  return core::TransitionGraph(std::move(row_begin), std::move(edges));
}

void PutClipGraph(FieldWriter& writer, const core::ClipGraph& graph) {
  writer.PutArray(graph.nodes);
  writer.PutArray(graph.frames);
  PutGraph(writer, graph.transitions);
}

core::ClipGraph GetClipGraph(FieldReader& reader) {
  core::ClipGraph graph;
  graph.nodes = reader.GetArray<std::int32_t>();
  graph.frames = reader.GetArray<std::int32_t>();
  graph.transitions = GetGraph(reader);
  return graph;
}

}  // namespace motiondb::storage
