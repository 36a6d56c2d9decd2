// Which clips are worth aligning with a window: those whose nodes it comes near. The functions are
// safe to call from any thread, the classes are scratch of one caller.
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/clip_index.h"
#include "core/model/motion_metric.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

class Model;

// Clips on a list at most.
inline constexpr std::size_t kMostShortlisted = 64;

// At most 64 clips, the nearest first. `observed`: frames x K, in the metric. A clip is as far as
// the mean, over at most 24 of the frames spread evenly, of the squared distance to the nearest
// mean among its nodes; only the 64 nodes nearest to a frame are looked at, and to the others it is
// taken to be as far as to the 64th. Noise moves an observation away from all nodes alike, so the
// order stays. Clips with `left_out[clip]` are passed over; it may be empty. Of the rest there is
// none that a database of 64 clips leaves out. The cost does not grow with the number of clips but
// for those found in these nodes.
// Where there are no more than 64, all are listed in their own order, without a look at the nodes.
// `own`: the metric, if it is not the model's.
std::vector<int> ShortlistClips(const Model& model, const MotionMetric* own,
                                const FrameMatrix& observed,
                                const std::vector<bool>& left_out = {});

// The same in parts, for windows that share frames.

// How much nearer a clip's nearest node is to a frame than the 64th node is.
struct NearClip {
  int clip = 0;  // index into Model::clips()
  float nearer = 0;
};

// Returns whether a shortlist has all of this number of clips, for any observation.
bool ListsAll(int clip_count);

// Which of `frames` frames are looked at, ascending.
std::vector<int> ShortlistFrames(int frames);

class NearClipFinder {
 public:
  // What it is made of must outlive it.
  NearClipFinder(const ClipIndex& index, int clip_count);
  // `squared_distances`: of a frame to the index's nodes. Replaces `near` by the clips of the
  // nearest.
  void Find(const Eigen::Ref<const Eigen::RowVectorXf>& squared_distances,
            std::vector<NearClip>& near);

 private:
  const ClipIndex& index_;
  std::vector<int> nodes_;              // nearest to the frame before
  std::vector<std::int64_t> found_by_;  // the frame that found a clip last
  std::int64_t frame_ = 0;
};

class ClipRanking {
 public:
  explicit ClipRanking(int clip_count) : nearer_(clip_count), is_found_(clip_count) {}
  // Takes one frame's clips.
  void Add(const std::vector<NearClip>& near);
  // The shortlist of the frames taken (none, where it lists all), and forgets them.
  std::vector<int> TakeShortlist(const std::vector<bool>& left_out);

 private:
  std::vector<float> nearer_;  // summed over the frames
  std::vector<bool> is_found_;
  std::vector<int> found_;
};

}  // namespace motiondb::core
