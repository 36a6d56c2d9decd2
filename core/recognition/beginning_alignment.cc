#include "core/recognition/beginning_alignment.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/recognition/alignment_loops.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

// The compared frames of all beginnings.
struct ComparedBeginnings {
  std::vector<int> shared;        // frames of the observation
  std::vector<int> shared_count;  // by beginning: number of `shared` frames before its newest
};

ComparedBeginnings FramesToCompare(const Beginnings& beginnings, int stride) {
  ComparedBeginnings compared;
  for (const int length : beginnings.lengths) {
    compared.shared = ComparedFrames(0, length, stride, true);
    compared.shared.pop_back();  // the newest
    compared.shared_count.push_back(static_cast<int>(compared.shared.size()));
  }
  return compared;
}

// Position of a unit's result for a beginning.
struct ResultIndex {
  int beginning = 0;
  int rank = 0;  // index among its units
};

// Squared whitened differences between observed and stored frames. Consecutive beginnings share
// most nearest frames, so the squares are cached.
class WhitenedSquares {
 public:
  WhitenedSquares(const Model& model, const FrameMatrix& shared_states)
      : model_(model),
        shared_(shared_states),
        frame_(shared_states.rows(), -1),
        squares_(shared_states.rows()) {}

  // Returns the mean over the frames and dimensions of a beginning. `nearest`: stored frames
  // nearest to the shared frames, then to the newest frame.
  double Mean(const std::vector<NearestFrame>& nearest,
              const Eigen::Ref<const Eigen::RowVectorXf>& newest) {
    const std::size_t shared = nearest.size() - 1;
    std::vector<std::size_t> changed;
    for (std::size_t f = 0; f < shared; ++f) {
      if (frame_[f] != nearest[f].frame) changed.push_back(f);
    }
    FrameMatrix differences(std::ssize(changed) + 1, newest.size());
    for (std::size_t i = 0; i < changed.size(); ++i) {
      const auto state = shared_.row(static_cast<Eigen::Index>(changed[i]));
      differences.row(static_cast<Eigen::Index>(i)) =
          state - NearestState(model_, nearest[changed[i]].frame, state);
    }
    differences.bottomRows(1) = newest - NearestState(model_, nearest[shared].frame, newest);
    const FrameMatrix whitened = RowProduct(differences, model_.metric().whitening);
    for (std::size_t i = 0; i < changed.size(); ++i) {
      frame_[changed[i]] = nearest[changed[i]].frame;
      squares_[changed[i]] = whitened.row(static_cast<Eigen::Index>(i)).squaredNorm();
    }
    double sum = whitened.bottomRows(1).squaredNorm();
    for (std::size_t f = 0; f < shared; ++f) sum += squares_[f];
    return sum / (static_cast<double>(nearest.size()) * static_cast<double>(whitened.cols()));
  }

 private:
  const Model& model_;
  const FrameMatrix& shared_;
  std::vector<int> frame_;  // stored frame of the cached difference
  std::vector<double> squares_;
};

// Aligns several units; reuses its memory.
class BeginningAligner {
 public:
  // A beginning consists of the first `shared_count` of the `shared` frames and its row of
  // `newest`. `shared_count` is ascending.
  BeginningAligner(const FrameMatrix& shared, const FrameMatrix& newest,
                   const std::vector<int>& shared_count)
      : shared_(shared), newest_(newest), shared_count_(shared_count) {}

  // Writes the log evidence of the beginnings `selected` (indices, ascending, not empty) and
  // updates their nearest frames.
  void Align(const MetricFrames& stored, RowRange rows, const std::vector<int>& selected,
             std::vector<std::vector<NearestFrame>>& nearest, std::vector<double>& log_evidence) {
    ReadNewest(stored, rows);
    inexact_.clear();
    FollowPaths(
        stored, rows, selected,
        [&](PathSum& paths, const auto& distances, int frame) {
          const float minimum = Minimum(distances.data(), static_cast<int>(distances.size()));
          for (const int b : selected) {
            if (frame < shared_count_[b])
              UpdateNearest(stored, rows, distances, minimum, nearest[b][frame]);
          }
          AddFrame(paths, distances, minimum);
        },
        [&](PathSum& paths, const auto& distances, int b) {
          const float minimum = Minimum(distances.data(), static_cast<int>(distances.size()));
          UpdateNearest(stored, rows, distances, minimum, nearest[b].back());
          AddFrame(paths, distances, minimum);
          if (!paths.IsExact()) inexact_.push_back(b);
          return paths.LogEvidence();
        },
        log_evidence);
    if (inexact_.empty()) return;
    const auto add = [](PathSum& paths, const auto& distances, int) { paths.AddFrame(distances); };
    FollowPaths(
        stored, rows, std::vector<int>(inexact_), add,
        [&](PathSum& paths, const auto& distances, int) {
          paths.AddFrame(distances);
          return paths.LogEvidence();
        },
        log_evidence);
  }

 private:
  void ReadNewest(const MetricFrames& stored, RowRange rows) {
    newest_distances_.resize(rows.count, newest_.count());
    for (int block = 0; block < newest_.block_count(); ++block) {
      newest_.ComputeDistances(stored, rows, block, distances_);
      newest_distances_.middleCols(block * kFrameLanes, newest_.CountOf(block)) =
          distances_.leftCols(newest_.CountOf(block));
    }
  }

  void AddFrame(PathSum& paths, const Eigen::Ref<const Eigen::ArrayXf>& distances, float minimum) {
    roots_.resize(distances.size());
    const bool cut_off = PathSum::Roots(distances, minimum, roots_);
    paths.AddRoots(roots_, minimum, cut_off);
  }

  // Follows the paths along the shared frames; at the end of each beginning, a copy continues to
  // its newest frame.
  template <typename AddShared, typename AddNewest>
  void FollowPaths(const MetricFrames& stored, RowRange rows, const std::vector<int>& selected,
                   const AddShared& add_shared, const AddNewest& add_newest,
                   std::vector<double>& log_evidence) {
    paths_.Begin(rows.count, true);
    auto next = selected.begin();
    const auto end_beginnings = [&](int frames_added) {
      for (; next != selected.end() && shared_count_[*next] == frames_added; ++next) {
        ended_ = paths_;
        log_evidence[*next] = add_newest(ended_, newest_distances_.col(*next), *next);
      }
    };
    end_beginnings(0);
    for (int block = 0; next != selected.end(); ++block) {
      shared_.ComputeDistances(stored, rows, block, distances_);
      for (int f = 0; f < shared_.CountOf(block) && next != selected.end(); ++f) {
        const int frame = block * kFrameLanes + f;
        add_shared(paths_, distances_.col(f), frame);
        end_beginnings(frame + 1);
      }
    }
  }

  const ObservedFrames shared_;
  const ObservedFrames newest_;
  const std::vector<int>& shared_count_;
  PathSum paths_;
  PathSum ended_;
  std::vector<int> inexact_;
  Eigen::ArrayXXf distances_;         // rows x frames of the block
  Eigen::ArrayXXf newest_distances_;  // rows x beginnings
  Eigen::ArrayXf roots_;
};

}  // namespace

std::vector<WindowAlignment> AlignBeginnings(const Model& model, const LabelUnits& units,
                                             const Beginnings& beginnings, const ClipMask* mask,
                                             int left_out_label) {
  const auto count = beginnings.lengths.size();
  const auto [frames, shared_count] =
      FramesToCompare(beginnings, FrameStride(model.settings().frame_rate_hz));
  const FrameMatrix shared_states = beginnings.states(frames, Eigen::all);
  const FrameMatrix projected = Project(model.metric(), beginnings.states);
  const FrameMatrix shared = projected(frames, Eigen::all);
  const FrameMatrix newest = Project(model.metric(), beginnings.newest);

  std::vector<WindowAlignment> alignments(count);
  std::vector<std::vector<NearestFrame>> nearest(count);
  std::map<int, std::vector<ResultIndex>> results;  // by unit, the shortest beginning first
  for (std::size_t b = 0; b < count; ++b) {
    FrameMatrix observed(shared_count[b] + 1, shared.cols());
    observed << shared.topRows(shared_count[b]), newest.row(static_cast<Eigen::Index>(b));
    alignments[b].frames = shared_count[b] + 1;
    alignments[b].noise = NoiseEnergy(projected.topRows(beginnings.lengths[b] - 1));
    nearest[b].assign(observed.rows(), {std::numeric_limits<float>::infinity(), 0});
    for (const int clip : ShortlistClips(model, nullptr, observed, mask)) {
      for (const LabelUnit& unit : units.of_clip(clip)) {
        if (unit.label >= 0 && unit.label == left_out_label) continue;
        results[static_cast<int>(&unit - units.all().data())].push_back(
            {static_cast<int>(b), static_cast<int>(alignments[b].units.size())});
        alignments[b].units.push_back({&unit, 0});
      }
    }
  }

  BeginningAligner aligner(shared, newest, shared_count);
  std::vector<int> selected;
  std::vector<double> log_evidence(count);
  for (const auto& [unit, unit_results] : results) {
    selected.clear();
    for (const ResultIndex& result : unit_results) selected.push_back(result.beginning);
    aligner.Align(model.metric_frames(), units.all()[unit].rows, selected, nearest, log_evidence);
    for (const ResultIndex& result : unit_results) {
      alignments[result.beginning].units[result.rank].log_evidence = log_evidence[result.beginning];
    }
  }

  WhitenedSquares squares(model, shared_states);
  for (std::size_t b = 0; b < count; ++b) {
    SortByEvidence(alignments[b].units);
    alignments[b].familiarity_score = FamiliarityOfDifference(
        squares.Mean(nearest[b], beginnings.newest.row(static_cast<Eigen::Index>(b))));
  }
  return alignments;
}

}  // namespace motiondb::core
