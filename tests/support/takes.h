// Long takes with labelled spans, joined from short clips.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/model/model_builder.h"

namespace motiondb::tests {

// Joins clips into one take. Each clip is a span of kActionTrack with its label, if it has one.
inline core::BuildInput JoinClips(const std::vector<core::BuildInput>& clips,
                                  const std::string& id) {
  core::BuildInput take;
  take.clip_id = id;
  take.subject = clips[0].subject;
  take.states = clips[0].states;
  Eigen::Index frames = 0;
  for (const core::BuildInput& clip : clips) frames += clip.states.frame_count();
  take.states.states.resize(frames, clips[0].states.states.cols());
  take.states.root_path.resize(frames, 3);
  std::vector<core::LabelSpan> spans;
  int first = 0;
  for (const core::BuildInput& clip : clips) {
    const int count = clip.states.frame_count();
    take.states.states.middleRows(first, count) = clip.states.states;
    take.states.root_path.middleRows(first, count) = clip.states.root_path;
    if (!clip.label().empty()) spans.push_back({clip.label(), first, count});
    first += count;
  }
  take.labels.Set(core::kActionTrack, std::move(spans));
  return take;
}

}  // namespace motiondb::tests
