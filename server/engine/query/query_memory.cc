#include "server/engine/query/query_memory.h"

#include <algorithm>

#include "core/inference/node_path.h"
#include "core/model/label_units.h"
#include "core/model/metric_frames.h"
#include "core/motion/error.h"
#include "core/recognition/recognize.h"
#include "core/recognition/shortlist.h"
#include "server/engine/representation.h"

namespace motiondb::server {
namespace {

using Bytes = std::int64_t;

int MarkerCount(const core::Model& model) { return model.marker_set().marker_count(); }

// States as floats, without a root path.
Bytes BytesOfRows(const core::Model& model, Bytes frames) {
  return frames * MarkerCount(model) * 24;
}

// Number of nodes of the layer; of all layers if the layer does not exist, which the query reports
// itself.
Bytes NodeCount(const core::Model& model, int layer) {
  const auto resolved = model.ResolveLayer(layer);
  return resolved.ok() ? model.tree().node_count(*resolved)
                       : static_cast<Bytes>(model.tree().branches().size());
}

// Back pointers of the dynamic programme, and the steps of two frames, whose lists may have
// capacity for twice as many paths.
Bytes BytesOfSteps(Bytes frames, Bytes candidates, Bytes paths) {
  return frames * (64 + 4 * candidates * paths) + 2 * candidates * (40 + 32 * paths);
}

// The lattice, its transitions and the steps of its best paths.
Bytes BytesOfNodePaths(const core::Model& model, Bytes frames,
                       const core::NodePathOptions& options) {
  constexpr Bytes kFrame = 384;
  constexpr Bytes kDescent = 40;  // a candidate in the descent of the tree
  constexpr Bytes kLattice = 20;  // a candidate and its index among the nodes
  constexpr Bytes kKeptRows = 512;
  constexpr Bytes kMaxTransitionTable = 1 << 20;
  const Bytes nodes = NodeCount(model, options.layer);
  // If the strict rule leaves no path through the candidates, all nodes are searched.
  const bool all = options.max_candidates == 0 || options.transition_floor == 0;
  const Bytes candidates = all ? nodes : std::min<Bytes>(2 * Bytes{options.max_candidates}, nodes);
  const Bytes visited = std::min(nodes, frames * candidates);
  const Bytes rows = visited <= kKeptRows ? visited * visited : visited;
  const Bytes down = frames * candidates * kDescent;
  const Bytes along = frames * (candidates * kLattice + 8 * options.path_count) +
                      BytesOfSteps(frames, candidates, options.path_count);
  return frames * kFrame + std::max(down, along) + 8 * rows + 16 * nodes +
         8 * std::min(candidates * candidates, kMaxTransitionTable);
}

// Stored frames of the longest clip, at the rate of clip comparison.
Bytes LongestCompared(const core::Model& model) {
  Bytes longest = 0;
  for (const core::ModelClip& clip : model.clips()) {
    longest = std::max<Bytes>(longest, clip.frame_count);
  }
  return longest / core::FrameStride(model.settings().frame_rate_hz) + 1;
}

// The metric of the observed markers, and the nodes and one clip in it.
Bytes BytesOfOwnMetric(const core::Model& model) {
  const Bytes dimensions = 6 * Bytes{MarkerCount(model)};
  const Bytes projected = model.metric().projection.cols();
  const auto nodes = static_cast<Bytes>(model.clip_index().node_count());
  return 8 * 8 * dimensions * dimensions + 4 * nodes * (dimensions + 2 * projected) +
         4 * LongestCompared(model) * (dimensions + 2 * projected);
}

}  // namespace

std::int64_t BytesToRecognize(const core::Model& model, const core::StateSequence& states,
                              const core::RecognizeOptions& options, int top_count) {
  constexpr Bytes kWindow = 512;    // with its message
  constexpr Bytes kScore = 64;      // of a clip or label
  constexpr Bytes kClipSent = 320;  // message with two names, and its serialized form
  constexpr Bytes kLabelSent = 200;
  const Bytes frames = states.frame_count();
  const core::WindowPlan plan = core::PlanWindows(model, states, options);
  const Bytes width = plan.width;
  const Bytes windows = plan.count;
  const bool align = plan.is_aligned;
  const Bytes nodes = NodeCount(model, options.layer);
  const auto clips = static_cast<Bytes>(model.clips().size());
  const Bytes compared = align ? std::min<Bytes>(clips, core::kMaxShortlisted) : clips;
  const auto labels =
      static_cast<Bytes>(core::UnitsOf(model, options.track, options.mask.get())->labels().size());
  const Bytes listed = top_count > 0 ? std::min<Bytes>(compared, top_count) : compared;
  Bytes bytes =
      BytesOfStates(states.frame_count(), MarkerCount(model)) + 2 * BytesOfRows(model, frames) +
      windows * (kWindow + (compared + labels) * kScore + listed * kClipSent + labels * kLabelSent);
  if (align) {
    constexpr Bytes kLanes = 16;
    bytes += 4 * frames * model.metric().projection.cols() + 8 * kLanes * LongestCompared(model) +
             24 * 4 * static_cast<Bytes>(model.clip_index().node_count()) + 16 * clips;
    if (states.states.hasNaN()) bytes += BytesOfOwnMetric(model);
    return plan.uses_graph ? bytes + 8 * width * nodes : bytes;
  }
  const bool top_paths = options.generation == core::Generation::kTopPaths;
  return bytes + 16 * width * nodes +
         (top_paths ? width * (256 + 12 * nodes) + BytesOfSteps(width, nodes, options.path_count)
                    : 0);
}

std::int64_t BytesToFind(const core::Model& model, int frames, const core::FindOptions& options) {
  constexpr Bytes kMatchSent = 320;  // match, message with a name, and its serialized form
  constexpr Bytes kMaxKept = 3 * core::kMaxMatches;
  constexpr Bytes kLanes = 16;
  constexpr Bytes kSearchedFrames = 24;
  constexpr Bytes kStep = 40;  // a path, its place in the order of costs
  const Bytes projected = model.metric().projection.cols();
  const Bytes longest = LongestCompared(model) * core::FrameStride(model.settings().frame_rate_hz);
  return BytesOfStates(frames, MarkerCount(model)) + 3 * BytesOfRows(model, frames) +
         3 * 4 * frames * projected + longest * (4 * kLanes + 4 * projected + kStep) +
         4 * kSearchedFrames * static_cast<Bytes>(model.clip_index().node_count()) +
         32 * static_cast<Bytes>(model.clips().size()) + BytesOfOwnMetric(model) +
         kMaxKept * static_cast<Bytes>(sizeof(core::MotionMatch)) + options.top_count * kMatchSent;
}

std::int64_t BytesToEstimate(const core::Model& model, const core::StateSequence& states,
                             const core::EstimateOptions& options) {
  constexpr Bytes kMarkerFilled = 56;  // result, message and serialized form
  constexpr Bytes kFrameFilled = 256;
  constexpr Bytes kMarkerRegressed = 16 << 10;
  constexpr Bytes kFrameTried = 1200;
  const Bytes frames = states.frame_count();
  const Bytes markers = MarkerCount(model);
  Bytes bytes = BytesOfStates(states.frame_count(), MarkerCount(model)) +
                BytesOfRows(model, frames) + BytesOfNodePaths(model, frames, options.search) +
                12 * frames * options.search.path_count;
  if (states.states.hasNaN()) {
    const Bytes filled = options.fill == core::Fill::kEveryFrame ? frames : 1;
    const Bytes tried = std::min<Bytes>(frames, std::llround(states.frame_rate_hz));
    bytes += filled * (kFrameFilled + markers * kMarkerFilled) + markers * kMarkerRegressed +
             tried * (kFrameTried + 24 * markers);
  }
  return bytes;
}

std::int64_t BytesToPredict(const core::Model& model, const core::StateSequence& states,
                            const core::PredictOptions& options) {
  constexpr Bytes kMarkerOfExamples = 120 << 10;  // keys of stored moments, and features
  constexpr Bytes kHorizon = 400;                 // result, message and serialized form
  constexpr Bytes kMarkerOfHorizon = 40;
  const auto history =
      static_cast<Bytes>(std::clamp(std::round(options.history_seconds * states.frame_rate_hz), 1.0,
                                    std::max(1.0, static_cast<double>(states.frame_count()))));
  core::NodePathOptions search;
  search.layer = options.layer;
  search.transition_floor = options.transition_floor;
  core::NodePathOptions bottom = search;
  bottom.layer = 0;
  const Bytes markers = MarkerCount(model);
  const auto horizons = static_cast<Bytes>(options.horizon_seconds.size());
  const Bytes bytes = BytesOfStates(states.frame_count(), MarkerCount(model)) +
                      BytesOfNodePaths(model, history, search) +
                      horizons * (kHorizon + markers * kMarkerOfHorizon);
  const Bytes of_history = BytesOfStates(history, MarkerCount(model));
  if (options.method == core::Method::kPaper) return bytes + 2 * of_history;
  return bytes + 5 * of_history + BytesOfNodePaths(model, history, bottom) +
         markers * kMarkerOfExamples;
}

ObserveMemory BytesToObserve(const core::Model& model, const core::ObserverOptions& options) {
  constexpr Bytes kKeptClips = 80;
  constexpr Bytes kMarkerKept = 64;  // of a frame: raw, as state and scaled
  constexpr Bytes kFrameKept = 256;
  const double rate = model.settings().frame_rate_hz;
  const auto in_frames = [&](double seconds) {
    return std::max<Bytes>(1, std::llround(seconds * rate));
  };
  const Bytes window = in_frames(options.window_seconds);
  const Bytes kept = in_frames(std::max({1.0, options.window_seconds, options.history_seconds}));
  const Bytes markers = MarkerCount(model);
  const Bytes nodes = NodeCount(model, options.layer);
  const Bytes projected = model.metric().projection.cols();
  const auto clips = static_cast<Bytes>(model.clips().size());
  // Each frame of the window against each frame of the compared clips.
  const Bytes compared = std::min(kKeptClips * LongestCompared(model),
                                  static_cast<Bytes>(model.metric_frames().rows.frame.size()));
  ObserveMemory memory;
  memory.kept = kept * (kFrameKept + markers * kMarkerKept) +
                window * (4 * projected + 24 * markers + 16 * clips + 4 * compared) + 16 * clips +
                64 * nodes;
  core::StateSequence history;
  history.frame_rate_hz = rate;
  core::PredictOptions predict;
  predict.history_seconds = options.history_seconds;
  predict.horizon_seconds = options.horizon_seconds;
  predict.transition_floor = options.transition_floor;
  history.states.resize(kept, 0);
  memory.answer = BytesOfOwnMetric(model) + 4 * BytesOfRows(model, window) +
                  8 * window * NodeCount(model, 0) +
                  (options.horizon_seconds.empty() ? 0 : BytesToPredict(model, history, predict));
  return memory;
}

std::int64_t BytesOfClipNames(const core::Prediction& prediction) {
  constexpr Bytes kName = 256;  // string and serialized form
  Bytes names = 0;
  for (const core::NextNode& next : prediction.next_nodes) names += std::ssize(next.clips);
  return names * kName;
}

std::int64_t BytesToPlan(const core::Model& model, const core::PlanProblem& problem) {
  constexpr Bytes kSearch = 12 << 20;
  constexpr Bytes kStoredFrame = 32;          // axis, path length, jolt, run
  constexpr Bytes kFrameSynthesis = 2 << 10;  // during the synthesis of a motion
  const double rate = problem.frame_rate_hz.value_or(model.settings().frame_rate_hz);
  const auto frames = static_cast<Bytes>(problem.max_duration_seconds * rate) + 1;
  const Bytes dofs = problem.skeleton == nullptr ? 0 : problem.skeleton->dof_count();
  const Bytes start =
      problem.start.observation
          ? BytesOfStates(problem.start.observation->frame_count(), MarkerCount(model))
          : 0;
  return start + kSearch + model.frame_count() * kStoredFrame + frames * kFrameSynthesis +
         frames * 3 * 8 * dofs +  // path through the poses, its steps and its samples
         // motions of two searches
         2 * frames * (1 + problem.alternative_count) * (24 + 8 * dofs + 12 * MarkerCount(model));
}

std::int64_t BytesOfPlan(const core::PlanAnswer& answer, bool with_files) {
  constexpr Bytes kFrame = 160;        // root and nodes
  constexpr Bytes kAngle = 8 + 3 * 4;  // result, floats, message and serialized form
  // Position and, of a robot with visual shapes, rotation: floats, message and serialized form.
  constexpr Bytes kJoint = 3 * (3 + 4) * 4;
  constexpr Bytes kAngleAsText = 160;  // in the longest format, NPZ, of a joint with one angle
  constexpr Bytes kCoordinateAsText = 4 * 12;
  Bytes bytes = 0;
  for (const core::PlannedMotion& motion : answer.motions) {
    const Bytes angles = motion.joints ? motion.joints->angles.size() : 0;
    const Bytes joints =
        motion.joints ? motion.joints->angles.rows() * motion.joints->skeleton->joint_count() : 0;
    bytes += kFrame * motion.root.rows() +
             motion.markers.positions_m.size() * (12 + (with_files ? kCoordinateAsText : 0)) +
             angles * (kAngle + (with_files ? kAngleAsText : 0)) + joints * kJoint;
  }
  return bytes;
}

absl::Status CheckScores(const std::vector<core::RecognizedWindow>& windows, int top_count) {
  constexpr std::size_t kMaxScores = 1 << 20;  // in a response, about 100 bytes each
  std::size_t scores = 0;
  for (const core::RecognizedWindow& window : windows) {
    const std::size_t clips = window.clips.size();
    scores += top_count == 0 ? clips : std::min(clips, static_cast<std::size_t>(top_count));
    scores += window.labels.size();
  }
  if (scores <= kMaxScores) return absl::OkStatus();
  return core::FieldViolation(
      "top_count",
      "the response would have {} clips and labels in {} windows, the limit is {}; set a smaller "
      "top_count or a longer hop",
      scores, windows.size(), kMaxScores);
}

}  // namespace motiondb::server
