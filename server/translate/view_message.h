// Converts figures, motion of clips and geometry of models to messages of ViewService.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <span>

#include "server/engine/query/clip_motion.h"
#include "server/engine/query/state_map.h"

namespace motiondb::v1 {
class Bone;
class Figure;
class GetNodePosesResponse;
class LinkVisual;
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

void SetMapHeader(const StateMap& map, v1::StateMapHeader& message);

// Append parts of the map. REQUIRES: they are its own.
void AddNodes(StateMap& map, std::span<const int> nodes, v1::StateMapNodes& message);
// The transitions first to end - 1.
void AddTransitions(const StateMap& map, int first, int end, v1::StateMapTransitions& message);
// Frames of the model.
void AddPoints(const StateMap& map, std::span<const int> frames, v1::StateMapPoints& message);

void SetNodePoses(const NodePoses& poses, v1::GetNodePosesResponse& message);

}  // namespace motiondb::server
