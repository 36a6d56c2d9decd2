// Converts models, nodes, transitions and states to messages.
#pragma once

#include "core/model/build_settings.h"
#include "storage/records.h"

namespace motiondb::core {
class Model;
}  // namespace motiondb::core

namespace motiondb::v1 {
class Model;
class Node;
class Transition;
class ReadStatesResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

struct Snapshot;
struct Transition;

// Sets the statistics of a stored or current model. `snapshot` is the current model of the
// database, or null.
void SetModel(const storage::ModelRecord& record, const core::BuildSettings& settings,
              const Snapshot* snapshot, v1::Model& message);

// REQUIRES: `layer` and `node` are in the model.
void SetNode(const core::Model& model, int layer, int node, v1::Node& message);

// Sets the states of the frames [first_frame, end_frame).
void SetStates(const core::Model& model, int first_frame, int end_frame,
               v1::ReadStatesResponse& message);

void SetTransition(const Transition& transition, v1::Transition& message);

}  // namespace motiondb::server
