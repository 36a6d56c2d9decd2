#include "tests/eval/peers/peer.h"

#include <algorithm>

namespace motiondb::tests {

PeerScale::PeerScale(core::Scaling scaling, const ClipSet& training) {
  Eigen::Index frames = 0;
  for (const EvalClip* clip : training) frames += clip->states.states.rows();
  core::FrameMatrix all(frames, training.front()->states.states.cols());
  Eigen::Index at = 0;
  for (const EvalClip* clip : training) {
    all.middleRows(at, clip->states.states.rows()) = clip->states.states;
    at += clip->states.states.rows();
  }
  scale_ = core::MakeFeatureScale(scaling, all);
  scale_.Apply(all);
  mean_ = all.colwise().mean();
}

core::FrameMatrix PeerScale::Apply(const core::StateSequence& sequence) const {
  core::FrameMatrix scaled = sequence.states;
  scale_.Apply(scaled);
  scaled.rowwise() -= mean_;
  return scaled;
}

int LabelIndex(const EvalClip& clip, const std::vector<std::string>& labels) {
  return static_cast<int>(std::find(labels.begin(), labels.end(), clip.label) - labels.begin());
}

}  // namespace motiondb::tests
