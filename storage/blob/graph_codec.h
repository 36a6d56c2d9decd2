// Transition graphs <-> fields of a model's bytes; storage/README.md gives the layout. The readers
// keep every promise of transition_graph.h or make the reader fail. Safe to call from any thread.
#pragma once

#include "core/graph/transition_graph.h"
#include "storage/blob/fields.h"

namespace motiondb::storage {

// Fewest bytes that a graph and a clip's graph take.
inline constexpr std::size_t kGraphBytes = 3 * sizeof(std::uint32_t);
inline constexpr std::size_t kClipGraphBytes = 2 * sizeof(std::uint32_t) + kGraphBytes;

void PutGraph(FieldWriter& writer, const core::TransitionGraph& graph);
core::TransitionGraph GetGraph(FieldReader& reader);

void PutClipGraph(FieldWriter& writer, const core::ClipGraph& graph);
core::ClipGraph GetClipGraph(FieldReader& reader);

}  // namespace motiondb::storage
