// Converts models, their nodes, transitions, states and geometry, figures, and motion of clips to
// messages.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <span>

#include "core/model/build_settings.h"
#include "server/engine/query/clip_motion.h"
#include "server/engine/query/model_query.h"
#include "storage/records.h"

namespace motiondb::core {
class Model;
}  // namespace motiondb::core

namespace motiondb::v1 {
class Bone;
class Figure;
class GetNodePosesResponse;
class LinkVisual;
class Model;
class Node;
class ReadClipMotionResponse;
class ReadStatesResponse;
class StateMapHeader;
class StateMapNodes;
class StateMapPoints;
class StateMapTransitions;
class Transition;
}  // namespace motiondb::v1

namespace motiondb::server {

struct Snapshot;

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

// Appends bones.
void AddBones(std::span<const core::BoneEnds> bones,
              google::protobuf::RepeatedPtrField<v1::Bone>& messages);

// Appends visual shapes.
void AddVisuals(std::span<const core::LinkVisual> visuals,
                google::protobuf::RepeatedPtrField<v1::LinkVisual>& messages);

void SetFigure(const Figure& figure, v1::Figure& message);

// Sets `count` frames of a clip, from `first_frame` on, every `stride`-th. REQUIRES: they exist.
void SetClipFrames(const ClipMotion& motion, int first_frame, int count, int stride,
                   v1::ReadClipMotionResponse& message);

void SetMapHeader(const StateMap& map, v1::StateMapHeader& message);

// Append parts of the map. REQUIRES: they are its own.
void AddNodes(StateMap& map, std::span<const int> nodes, v1::StateMapNodes& message);
// The transitions first to end - 1.
void AddTransitions(const StateMap& map, int first, int end, v1::StateMapTransitions& message);
// Frames of the model.
void AddPoints(const StateMap& map, std::span<const int> frames, v1::StateMapPoints& message);

void SetNodePoses(const NodePoses& poses, v1::GetNodePosesResponse& message);

}  // namespace motiondb::server
