// Converts figures, motion of clips and geometry of models to messages of ViewService.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <span>

#include "server/engine/query/clip_motion.h"
#include "server/engine/snapshot.h"
#include "server/translate/model_message.h"

namespace motiondb::core {
struct MeanPose;
class NodeSummaries;
struct StateAxes;
}  // namespace motiondb::core

namespace motiondb::v1 {
class Bone;
class Figure;
class LinkVisual;
class NodePose;
class ReadClipMotionResponse;
class StateMapHeader;
class StateMapNodes;
class StateMapPoints;
class StateMapTransitions;
}  // namespace motiondb::v1

namespace motiondb::server {

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

// Sets all but the numbers of nodes, transitions and points.
void SetMapHeader(const Snapshot& snapshot, const core::StateAxes& axes, int layer,
                  v1::StateMapHeader& message);

// Appends nodes of a layer. REQUIRES: they exist.
void AddNodes(const core::Model& model, core::NodeSummaries& summaries, int layer,
              std::span<const int> nodes, v1::StateMapNodes& message);

// Appends the transitions first to end - 1 of a list.
void AddTransitions(const TransitionList& transitions, int first, int end,
                    v1::StateMapTransitions& message);

// Appends frames of the model as points.
void AddPoints(const core::Model& model, const core::StateAxes& axes, int layer,
               std::span<const int> frames, v1::StateMapPoints& message);

void SetNodePose(int node, const core::MeanPose& pose, v1::NodePose& message);

}  // namespace motiondb::server
