#include "core/planning/segment_search.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/motion/error.h"
#include "core/planning/goal.h"
#include "core/planning/seeded.h"

namespace motiondb::core {
namespace {

constexpr double kJoinSeconds = 0.15;       // minimum cost of a join
constexpr double kDistanceSeconds = 2.0;    // per unit of distance between the states
constexpr double kGlitchSeconds = 3;        // for each run with a glitch
constexpr double kCorrectionSeconds = 0.5;  // for the maximum correction
constexpr double kUsedTolerance = 0.8;      // fraction; the rest is for inverse kinematics
constexpr double kClearanceMargin = 0.01;   // m, for motion between the checked poses

// Parameters of one sweep of the search. Poses in one cell of the floor, in runs of one node, are
// merged. A greedier sweep finds a first answer sooner, with a longer path.
struct Sweep {
  double cell_leg_lengths;  // 0: poses are not merged
  double cell_rad;
  double greed;             // weight of the remaining cost
  std::int64_t expansions;  // maximum at effort 1
};
constexpr Sweep kFirst = {0.18, 0.2, 4, 20000};
constexpr Sweep kThorough = {0.24, 0.3, 3, 30000};  // if the first sweep finds nothing
// If both find nothing: all paths, with a limit.
constexpr Sweep kExhaustive = {0, 0, 1, 10000};
// After an answer: for better ones; its cost bounds this sweep.
constexpr Sweep kCloser = {0.12, 0.15, 2, 8000};
constexpr int kExpansionsBetweenChecks = 8;  // between calls to the caller

constexpr std::int32_t kNoJoin = -1;

// A run entered at its first frame (or at the start frame) with a pose.
struct Arrival {
  std::int32_t run = 0;
  std::int32_t from = -1;       // previous arrival
  std::int32_t join = kNoJoin;  // join of the previous run; kNoJoin: same clip
  std::int32_t segment = 0;     // first arrival since the last join
  std::int32_t since_join = 0;  // frames played since the last join
  std::int32_t frames = 0;      // frames played since the start
  FloorPose pose;
  double length_m = 0;
  double cost = 0;
};

struct Visit {
  double cost = 0;
  std::int32_t segment = 0;
};

struct Ending {
  std::int32_t arrival = -1;
  std::int32_t join = kNoJoin;  // join from that run before the end
  std::int32_t frame = 0;
  double cost = 0;
  double violation = std::numeric_limits<double>::infinity();
};

class Search {
 public:
  Search(SegmentGraph& graph, const StoredFloor& floor, int start_frame, const Obstacles& obstacles,
         const FloorField& field, const SearchSettings& settings)
      : graph_(graph),
        floor_(floor),
        start_frame_(start_frame),
        obstacles_(obstacles),
        settings_(settings),
        goal_(settings.goal.x, settings.goal.y),
        field_(field),
        speed_(std::max(1e-3, floor.top_speed_m_s())),
        turn_(std::max(1e-3, floor.top_turn_rad_s())),
        margin_(std::clamp(Distance(obstacles, Eigen::Vector2d::Zero()) - obstacles.clearance_m,
                           0.0, kClearanceMargin)),
        max_frames_(
            static_cast<std::int32_t>(settings.max_duration_seconds * settings.frame_rate_hz)) {}

  absl::StatusOr<FoundPaths> Run(const PlanControl& control) {
    MOTIONDB_RETURN_IF_ERROR(RunSweep(kFirst, settings_.path_count, control));
    if (endings_.empty()) {
      MOTIONDB_RETURN_IF_ERROR(RunSweep(kThorough, settings_.path_count, control));
    }
    if (endings_.empty()) {
      MOTIONDB_RETURN_IF_ERROR(RunSweep(kExhaustive, 1, control));
      found_.effort.complete = open_.empty();
    }
    if (!endings_.empty()) {
      MOTIONDB_RETURN_IF_ERROR(RunSweep(kCloser, std::numeric_limits<int>::max(), control));
    }
    Collect();
    return std::move(found_);
  }

 private:
  // Runs a sweep until `enough` paths are known. CANCELLED.
  absl::Status RunSweep(const Sweep& sweep, int enough, const PlanControl& control) {
    sweep_ = sweep;
    visits_.clear();
    open_ = {};
    Enter({.run = graph_.run_of_frame(start_frame_)});
    const auto max_expansions =
        static_cast<std::int64_t>(settings_.effort * static_cast<double>(sweep.expansions));
    for (std::int64_t i = 0; i < max_expansions && !open_.empty() && !found_.time_up; ++i) {
      if (i % kExpansionsBetweenChecks == 0) {
        if (control.cancelled && control.cancelled()) {
          return absl::CancelledError("the search was cancelled");
        }
        found_.time_up = control.time_up && control.time_up();
      }
      const std::int32_t next = open_.top().second;
      open_.pop();
      if (!MayImprove(next)) continue;
      ++found_.effort.expansions;
      Expand(next);
      if (static_cast<int>(endings_.size()) >= enough) return absl::OkStatus();
    }
    return absl::OkStatus();
  }

  // Lower bound of the remaining time (s) to come within tolerance.
  double RemainingSeconds(const FloorPose& pose) const {
    const double path_m = field_.DistanceToGoal({pose.x, pose.y}) - settings_.position_tolerance_m;
    const double turn = std::abs(WrapAngle(settings_.goal.heading - pose.heading)) -
                        settings_.heading_tolerance_rad;
    return std::max({0.0, path_m / speed_, turn / turn_});
  }

  bool Clear(const FloorPose& pose, double margin) const {
    return field_.HasClearance({pose.x, pose.y}, obstacles_.clearance_m + margin);
  }

  int EntryFrame(const Arrival& arrival) const {
    return arrival.from < 0 ? start_frame_ : graph_.runs()[arrival.run].first;
  }

  double WorstKept() const {
    return static_cast<int>(endings_.size()) < settings_.path_count
               ? std::numeric_limits<double>::infinity()
               : endings_.back().cost;
  }

  bool MayImprove(std::int32_t index) const {
    const Arrival& arrival = arrivals_[index];
    return arrival.cost + RemainingSeconds(arrival.pose) < WorstKept();
  }

  double JoinCost(const RunJoin& join) const {
    double cost = kJoinSeconds + kDistanceSeconds * join.distance;
    if (settings_.seed != 0) {
      const std::uint64_t key =
          Mix(Mix(settings_.seed) ^ static_cast<std::uint64_t>(join.join.leave)) ^
          static_cast<std::uint64_t>(join.join.enter);
      cost *= 1 + ToUnit(Mix(key));
    }
    return cost;
  }

  void Enter(Arrival arrival) {
    if (arrival.frames > max_frames_ || !Clear(arrival.pose, margin_)) return;
    const double remaining = RemainingSeconds(arrival.pose);
    // A correction may cover the last part.
    const bool in_time =
        arrival.frames + (1 - kMaxCorrection) * remaining * settings_.frame_rate_hz <=
        max_frames_ + 1;
    if (arrival.from >= 0 && (!in_time || arrival.cost + remaining >= WorstKept())) return;
    const auto index = static_cast<std::int32_t>(arrivals_.size());
    if (arrival.from < 0 || arrival.join != kNoJoin) arrival.segment = index;
    if (sweep_.cell_leg_lengths > 0 && !IsNew(arrival)) return;
    open_.push({arrival.cost + sweep_.greed * remaining, index});
    arrivals_.push_back(arrival);
  }

  // Whether no cheaper arrival exists in its cell; if so, registers this one.
  bool IsNew(const Arrival& arrival) {
    const auto cell = [](double value, double size) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / size)));
    };
    const double cell_m = sweep_.cell_leg_lengths * floor_.leg_length_m();
    const auto node = static_cast<std::uint64_t>(graph_.runs()[arrival.run].node);
    const std::uint64_t key =
        Mix(Mix(Mix(Mix(node) ^ cell(arrival.pose.x, cell_m)) ^ cell(arrival.pose.y, cell_m)) ^
            cell(WrapAngle(arrival.pose.heading), sweep_.cell_rad));
    const auto [known, is_new] = visits_.try_emplace(key, Visit{arrival.cost, arrival.segment});
    // A segment that returns to its own cell continues: a standing person may walk later.
    if (!is_new && known->second.cost <= arrival.cost && known->second.segment != arrival.segment) {
      return false;
    }
    if (arrival.cost <= known->second.cost) known->second = {arrival.cost, arrival.segment};
    return true;
  }

  void Expand(std::int32_t index) {
    const Arrival arrival = arrivals_[index];  // a copy: arrivals_ grows
    const int entry = EntryFrame(arrival);
    const auto& run = graph_.runs()[arrival.run];
    const bool settled = arrival.since_join >= graph_.half_window() || FirstSegment(arrival);
    // A motion has at least two frames.
    const int first_end = arrival.from < 0 ? entry + 1 : entry;
    TryEnds(index, kNoJoin, settled ? first_end : entry + graph_.half_window() - arrival.since_join,
            run.last, entry, arrival.pose, arrival.frames, arrival.length_m, arrival.cost);
    if (run.continues) {
      Advance(index, kNoJoin, arrival.run + 1, entry, arrival.pose, arrival.frames,
              arrival.length_m, arrival.cost, arrival.since_join);
    }
    const std::vector<RunJoin>& joins = graph_.Joins(arrival.run);
    for (std::size_t j = 0; j < joins.size(); ++j) {
      const RunJoin& join = joins[j];
      const int played = join.join.leave - entry;
      // Windows must not overlap, and the first needs frames before it.
      if (played < 0 || arrival.since_join + played < 2 * graph_.half_window()) continue;
      const int window = join.join.half_window;
      const FloorPose pose =
          arrival.pose * floor_.Between(entry, join.join.leave - window) * join.across;
      const double across_m = std::hypot(join.across.x, join.across.y);
      const double length =
          arrival.length_m + SignedLength(entry, join.join.leave - window) + across_m;
      const double cost = arrival.cost + JoinCost(join) + played / settings_.frame_rate_hz;
      const int landed = join.join.enter + window;  // the frame of `pose`
      const int frames = arrival.frames + played + window;
      const auto number = static_cast<std::int32_t>(j);
      const double landed_cost = cost + window / settings_.frame_rate_hz;
      TryEnds(index, number, landed, graph_.runs()[join.to].last, landed, pose, frames, length,
              landed_cost);
      if (graph_.runs()[join.to].continues) {
        Advance(index, number, join.to + 1, landed, pose, frames, length, landed_cost, window);
      }
    }
  }

  // The start's clip has no join before it, so there is no window to complete.
  bool FirstSegment(const Arrival& arrival) const { return arrival.since_join == arrival.frames; }

  // Path length along a clip, negative backwards.
  double SignedLength(int from, int to) const {
    return to >= from ? floor_.Length(from, to) : -floor_.Length(to, from);
  }

  // Continues to the first frame of the run `to`; `pose` and the following values are at frame
  // `at`.
  void Advance(std::int32_t from, std::int32_t join, std::int32_t to, int at, const FloorPose& pose,
               int frames, double length, double cost, int since_join) {
    const int first = graph_.runs()[to].first;
    const int played = first - at;
    Enter({.run = to,
           .from = from,
           .join = join,
           .segment = arrivals_[from].segment,
           .since_join = since_join + played,
           .frames = frames + played,
           .pose = pose * floor_.Between(at, first),
           .length_m = length + SignedLength(at, first),
           .cost = cost + played / settings_.frame_rate_hz +
                   (graph_.IsFreeOfGlitches(to) ? 0 : kGlitchSeconds)});
  }

  // Checks whether the motion can end at one of the frames first ... last; `pose` and the following
  // values are at frame `at`.
  void TryEnds(std::int32_t arrival, std::int32_t join, int first, int last, int at,
               const FloorPose& pose, int frames, double length, double cost) {
    if (first > last || frames + first - at > max_frames_) return;
    const double reach = settings_.position_tolerance_m +
                         std::abs(SignedLength(at, last)) * (1 + kMaxCorrection) +
                         kMaxCorrection * length;
    const bool near = std::hypot(pose.x - goal_.x(), pose.y - goal_.y()) <= reach;
    for (int frame = first; frame <= (near ? last : first); ++frame) {
      const int played = frame - at;
      if (frames + played > max_frames_) break;
      Consider({.arrival = arrival,
                .join = join,
                .frame = frame,
                .cost = cost + played / settings_.frame_rate_hz},
               pose * floor_.Between(at, frame), length + SignedLength(at, frame));
    }
  }

  void Consider(Ending ending, const FloorPose& end, double length) {
    const GoalError residual = ErrorAfterCorrection(end, length, settings_.goal);
    const double violation =
        std::max(0.0, residual.position_m - kUsedTolerance * settings_.position_tolerance_m) +
        std::max(0.0, residual.heading_rad - kUsedTolerance * settings_.heading_tolerance_rad);
    ending.violation = violation;
    if (violation > 0) {
      if (violation < nearest_.violation && IsClear(Corrected(ending).poses)) nearest_ = ending;
      return;
    }
    const GoalError error = ErrorAt(end, settings_.goal);
    if (length > 0) {
      ending.cost +=
          kCorrectionSeconds *
          std::min(1.0, std::max(error.position_m, error.heading_rad) / (kMaxCorrection * length));
    }
    if (ending.cost < WorstKept() && Arrives(ending)) Keep(ending);
  }

  // Returns the corrected root path.
  CorrectedRoot Corrected(const Ending& ending) const {
    return CorrectRoot(PlayedRoot(floor_, PathTo(ending)), settings_.goal);
  }

  bool IsClear(const std::vector<FloorPose>& root) const {
    return obstacles_.empty() || std::all_of(root.begin(), root.end(), [&](const FloorPose& pose) {
             return Clear(pose, margin_ / 2);
           });
  }

  bool Arrives(const Ending& ending) const {
    const CorrectedRoot root = Corrected(ending);
    const GoalError error = ErrorAt(root.poses.back(), settings_.goal);
    return error.position_m <= kUsedTolerance * settings_.position_tolerance_m &&
           error.heading_rad <= kUsedTolerance * settings_.heading_tolerance_rad &&
           IsClear(root.poses);
  }

  // Keeps one ending for each path: another end frame of the same runs is not another plan.
  void Keep(const Ending& ending) {
    const auto same = std::find_if(endings_.begin(), endings_.end(), [&](const Ending& other) {
      return LastJoinOf(other) == LastJoinOf(ending);
    });
    if (same != endings_.end()) {
      if (same->cost <= ending.cost) return;
      endings_.erase(same);
    }
    if (endings_.empty() || ending.cost < endings_.front().cost) ++found_.effort.improvements;
    const auto after =
        std::upper_bound(endings_.begin(), endings_.end(), ending,
                         [](const Ending& a, const Ending& b) { return a.cost < b.cost; });
    endings_.insert(after, ending);
    if (static_cast<int>(endings_.size()) > settings_.path_count) endings_.pop_back();
  }

  // Returns the last join of a path as a pair of frames.
  std::pair<int, int> LastJoinOf(const Ending& ending) const {
    const SplicedPath path = PathTo(ending);
    if (path.joins.empty()) return {-1, -1};
    return {path.joins.back().leave, path.joins.back().enter};
  }

  SplicedPath PathTo(const Ending& ending) const {
    SplicedPath path{.start = start_frame_, .end = ending.frame};
    const auto add = [&](std::int32_t run, std::int32_t join) {
      if (join != kNoJoin) path.joins.push_back(graph_.Joins(run)[join].join);
    };
    add(arrivals_[ending.arrival].run, ending.join);
    for (std::int32_t i = ending.arrival; arrivals_[i].from >= 0; i = arrivals_[i].from) {
      add(arrivals_[arrivals_[i].from].run, arrivals_[i].join);
    }
    std::reverse(path.joins.begin(), path.joins.end());
    return path;
  }

  void Collect() {
    found_.reached = !endings_.empty();
    if (endings_.empty() && nearest_.arrival >= 0) endings_.push_back(nearest_);
    for (const Ending& ending : endings_) {
      found_.paths.push_back({PathTo(ending), ending.cost, ending.violation});
    }
  }

  SegmentGraph& graph_;
  const StoredFloor& floor_;
  const int start_frame_;
  const Obstacles& obstacles_;
  const SearchSettings& settings_;
  const Eigen::Vector2d goal_;
  const FloorField& field_;
  const double speed_;
  const double turn_;
  const double margin_;  // of clearance; at most that of the start
  const std::int32_t max_frames_;

  Sweep sweep_{};
  std::deque<Arrival> arrivals_;  // not a vector, which would double its memory when growing
  std::priority_queue<std::pair<double, std::int32_t>, std::vector<std::pair<double, std::int32_t>>,
                      std::greater<>>
      open_;
  std::unordered_map<std::uint64_t, Visit> visits_;  // cheapest arrival of each cell
  std::vector<Ending> endings_;                      // cheapest first, at most path_count
  Ending nearest_;
  FoundPaths found_;
};

}  // namespace

absl::StatusOr<FoundPaths> SearchSegments(SegmentGraph& graph, const StoredFloor& floor,
                                          int start_frame, const Obstacles& obstacles,
                                          const FloorField& field, const SearchSettings& settings,
                                          const PlanControl& control) {
  return Search(graph, floor, start_frame, obstacles, field, settings).Run(control);
}

}  // namespace motiondb::core
