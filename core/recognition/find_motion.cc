#include "core/recognition/find_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/inference/observation.h"
#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/recognition/cheapest_path.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kMinShortlisted = 256;
constexpr std::size_t kMinCompared = 32;

absl::Status WasCancelled() { return absl::CancelledError("the query was cancelled"); }

// Returns the frames of a part of `frames` frames.
absl::StatusOr<FrameRange> FramesOfPart(const TimeRange& part, int frames, double rate) {
  const double duration = frames / rate;
  const double start = part.start_seconds.value_or(0);
  const double end = part.end_seconds.value_or(duration);
  // Half a frame more, because times may be rounded.
  const double latest = duration + 0.5 / rate;
  if (!(start >= 0 && start < latest)) {
    return FieldViolation("start_seconds",
                          "expected at least 0 and less than {:g}, the duration, got {:g}",
                          duration, start);
  }
  if (!(end > start && end <= latest)) {
    return FieldViolation("end_seconds",
                          "expected more than the start, {:g}, and at most the duration, {:g}, got "
                          "{:g}",
                          start, duration, end);
  }
  const int first = std::min(static_cast<int>(std::lround(start * rate)), frames - 1);
  const int last = std::min(static_cast<int>(std::lround(end * rate)), frames);
  return FrameRange{first, std::max(first + 1, last)};
}

// Returns all frames of a clip in the metric, relative to `centre`, as the rows from 0.
MetricFrames ProjectClip(const Model& model, const MotionMetric& metric, const ModelClip& clip,
                         const Eigen::RowVectorXf& centre) {
  constexpr int kBlockRows = 256;  // centred states stay in the processor cache
  FrameMatrix projected(clip.frame_count, metric.projection.cols());
  for (int first = 0; first < clip.frame_count; first += kBlockRows) {
    const int count = std::min(kBlockRows, clip.frame_count - first);
    projected.middleRows(first, count) =
        Project(metric, model.states().middleRows(clip.first_frame + first, count)).rowwise() -
        centre;
  }
  MetricFrames frames;
  frames.squared_norms = projected.rowwise().squaredNorm();
  frames.projected = SharedRows(std::move(projected));
  return frames;
}

class MotionSearch {
 public:
  MotionSearch(const Model& model, const MetricObservation& observation, const FindOptions& options,
               const Cancelled& cancelled)
      : model_(model), observation_(observation), options_(options), cancellation_(cancelled) {}

  // Returns the clips to compare at the database's frame rate.
  absl::StatusOr<std::vector<int>> ClipsToCompare() {
    if (options_.exhaustive) return AllowedClips(model_, options_.mask.get());
    const auto top = static_cast<std::size_t>(options_.top_count);
    const std::size_t compared = std::max(kMinCompared, 2 * top);
    const std::vector<int> shortlist =
        ShortlistClips(model_, observation_.own.get(), observation_.projected, options_.mask.get(),
                       std::max(kMinShortlisted, 4 * top));
    if (shortlist.size() <= compared) return shortlist;
    std::vector<CheapestPaths> phases = StridedPhases();
    std::vector<std::pair<double, int>> costs;
    for (const int clip : shortlist) {
      const std::optional<double> cost = LeastStridedCost(clip, phases);
      if (!cost) return WasCancelled();
      costs.emplace_back(*cost, clip);
    }
    std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(compared),
                     costs.end());
    std::vector<int> clips;
    for (std::size_t i = 0; i < compared; ++i) clips.push_back(costs[i].second);
    return clips;
  }

  absl::StatusOr<std::vector<MotionMatch>> Compare(const std::vector<int>& clips) {
    // Rounding errors grow with the distances from the origin.
    const Eigen::RowVectorXf centre = observation_.projected.colwise().mean();
    CheapestPaths paths(observation_.projected.rowwise() - centre);
    const MotionMetric& metric = observation_.MetricFor(model_);
    const auto unit = static_cast<double>(2 * metric.projection.cols());
    for (const int clip : clips) {
      const MetricFrames stored = ProjectClip(model_, metric, model_.clips()[clip], centre);
      if (!paths.Search(stored, {0, model_.clips()[clip].frame_count}, cancellation_)) {
        return WasCancelled();
      }
      for (const PathRows& path : paths.Disjoint(options_.top_count)) {
        matches_.push_back(
            {clip, path.first, path.last - path.first + 1, 1 / (1 + path.cost / unit)});
      }
      if (matches_.size() >= 2 * kMaxMatches) KeepBest();
    }
    KeepBest();
    return std::move(matches_);
  }

 private:
  // Returns the observation at the rate of the model's metric frames, from each of the frames
  // before the first stride: a part of a clip has the same frames as the stored rows only from one
  // of them.
  std::vector<CheapestPaths> StridedPhases() const {
    const auto frames = static_cast<int>(observation_.projected.rows());
    const int stride = FrameStride(model_.settings().frame_rate_hz);
    std::vector<CheapestPaths> phases;
    for (int first = 0; first < std::min(stride, frames); ++first) {
      const int count = (frames - first + stride - 1) / stride;
      phases.emplace_back(observation_.projected(Eigen::seqN(first, count, stride), Eigen::all));
    }
    return phases;
  }

  // Returns the cost of the cheapest path of all phases through a clip; none if cancelled.
  std::optional<double> LeastStridedCost(int clip, std::vector<CheapestPaths>& phases) {
    const RowRange rows = model_.metric_frames().rows.of_clip(clip);
    MetricFrames in_own;
    if (observation_.own) in_own = ProjectStridedRows(model_, *observation_.own, rows);
    double least = std::numeric_limits<double>::infinity();
    for (CheapestPaths& paths : phases) {
      const bool is_done = observation_.own
                               ? paths.Search(in_own, {0, rows.count}, cancellation_)
                               : paths.Search(model_.metric_frames(), rows, cancellation_);
      if (!is_done) return std::nullopt;
      least = std::min(least, paths.least_cost());
    }
    return least;
  }

  void KeepBest() {
    const auto order = [&](const MotionMatch& match) {
      return std::tuple<double, const std::string&, int>(
          -match.score, model_.clips()[match.clip].id, match.first_frame);
    };
    const auto kept = std::min<std::size_t>(options_.top_count, matches_.size());
    std::partial_sort(
        matches_.begin(), matches_.begin() + static_cast<std::ptrdiff_t>(kept), matches_.end(),
        [&](const MotionMatch& a, const MotionMatch& b) { return order(a) < order(b); });
    matches_.resize(kept);
  }

  const Model& model_;
  const MetricObservation& observation_;
  const FindOptions& options_;
  ThrottledCancellation cancellation_;
  std::vector<MotionMatch> matches_;
};

}  // namespace

absl::Status CheckOptions(const FindOptions& options) {
  if (options.top_count >= 1 && options.top_count <= kMaxMatches) return absl::OkStatus();
  return FieldViolation("top_count", "expected 1 to {}, got {}", kMaxMatches, options.top_count);
}

absl::StatusOr<MotionPart> PartOfObservation(const Model& model, const StateSequence& observation,
                                             const TimeRange& part) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  MOTIONDB_ASSIGN_OR_RETURN(const FrameRange frames, FramesOfPart(part, observation.frame_count(),
                                                                  observation.frame_rate_hz));
  return MotionPart{scaled.middleRows(frames.first, frames.end - frames.first)};
}

absl::StatusOr<MotionPart> PartOfClip(const Model& model, const std::string& clip,
                                      const TimeRange& part) {
  const auto found = std::ranges::find(model.clips(), clip, &ModelClip::id);
  if (found == model.clips().end()) {
    return WithReason("CLIP_NOT_FOUND",
                      FieldViolation("clip", "clip '{}' is not in the model", clip));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const FrameRange frames,
                            FramesOfPart(part, found->frame_count, model.settings().frame_rate_hz));
  return MotionPart{
      model.states().middleRows(found->first_frame + frames.first, frames.end - frames.first),
      static_cast<int>(found - model.clips().begin())};
}

absl::StatusOr<std::vector<MotionMatch>> FindMotion(const Model& model, MotionPart motion,
                                                    const FindOptions& options,
                                                    const Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  if (model.metric().empty()) {
    return FailedPrecondition(
        "the model was built by an old version and cannot be searched; ingest a clip, so that a "
        "new "
        "model is built");
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto observation,
                            MetricObservation::Create(model, std::move(motion.states), cancelled));
  MotionSearch search(model, observation, options, cancelled);
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<int> clips, search.ClipsToCompare());
  const bool is_stored = motion.clip >= 0 && Allows(options.mask.get(), motion.clip);
  if (is_stored && std::ranges::count(clips, motion.clip) == 0) clips.push_back(motion.clip);
  return search.Compare(clips);
}

}  // namespace motiondb::core
