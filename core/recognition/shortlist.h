// Selects the clips to align with a window: those with nodes near the window. The classes are not
// thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/metric_frames.h"
#include "core/model/motion_metric.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

class ClipMask;
class Model;

// Maximum number of clips in a shortlist of recognition.
inline constexpr std::size_t kMaxShortlisted = 64;

// Returns at most `max_clips` clips, the nearest first. `observed`: frames x K, in the metric. The
// distance of a clip is the mean, over at most 24 evenly spread frames, of the squared distance to
// the nearest of its node means. Only the 64 nodes nearest to a frame are searched; a clip in none
// of them gets the distance of the 64th node. Noise increases all distances by about the same
// amount, so it hardly changes the order. Only clips that `mask` allows (null: all) and the nodes
// that contain their frames count. If these are at most `max_clips`, all are listed in their order,
// and the nodes are not searched. `own`: the metric; null: the metric of the model. Cost:
// independent of the number of clips, except for those found in the searched nodes.
std::vector<int> ShortlistClips(const Model& model, const MotionMetric* own,
                                const FrameMatrix& observed, const ClipMask* mask = nullptr,
                                std::size_t max_clips = kMaxShortlisted);

// The steps of ShortlistClips, for windows that share frames:

// Difference between the squared distances of a frame from the 64th node and from a clip's nearest
// node.
struct NearClip {
  int clip = 0;  // index into Model::clips()
  float nearer = 0;
};

// Returns whether a shortlist always has all of `clip_count` allowed clips.
bool ListsAll(int clip_count, std::size_t max_clips = kMaxShortlisted);

// Returns the indices of the searched frames among `frames` frames, ascending.
std::vector<int> ShortlistFrames(int frames);

class NearClipFinder {
 public:
  // The index must outlive the finder.
  NearClipFinder(const ClipIndex& index, int clip_count);
  // Replaces `near` by the clips of the nodes nearest to a frame. `squared_distances`: from the
  // frame to each node of the index.
  void Find(const Eigen::Ref<const Eigen::RowVectorXf>& squared_distances,
            std::vector<NearClip>& near);

 private:
  const ClipIndex& index_;
  std::vector<int> nodes_;              // nearest to the previous frame
  std::vector<std::int64_t> found_by_;  // for each clip: the last frame that found it
  std::int64_t frame_ = 0;
};

class ClipRanking {
 public:
  explicit ClipRanking(int clip_count) : nearer_(clip_count), is_found_(clip_count) {}
  // Adds the clips of one frame.
  void Add(const std::vector<NearClip>& near);
  // Returns the shortlist of the added frames and clears the ranking. If all clips are listed
  // (ListsAll), no frames need to be added. The added clips are allowed by `mask`.
  std::vector<int> TakeShortlist(const ClipMask* mask, std::size_t max_clips = kMaxShortlisted);

 private:
  std::vector<float> nearer_;  // summed over the frames
  std::vector<bool> is_found_;
  std::vector<int> found_;
};

}  // namespace motiondb::core
