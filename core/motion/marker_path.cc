#include "core/motion/marker_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/motion/samples.h"

namespace motiondb::core {

namespace {

constexpr double kNoise = 5;  // medians of the second difference
constexpr double kStillSeconds = 0.05;
constexpr int kStillFrames = 3;
constexpr double kSuspect = 0.2;          // fraction of the limits
constexpr int kPiecesBack = 64;           // candidate predecessors of a piece
constexpr double kDoubtfulWeight = 1e-3;  // of a doubtful frame

using Point = Eigen::RowVector3d;

class Path {
 public:
  Path(const MarkerPath& at, double frame_rate_hz, const PathLimits& limits)
      : at_(at), dt_(1 / frame_rate_hz), limits_(limits) {
    const auto frames = static_cast<int>(at.rows());
    std::vector<double> bends;
    for (int t = 1; t + 1 < frames; ++t) {
      const double bend = (at.row(t - 1) - 2 * at.row(t) + at.row(t + 1)).norm();
      if (std::isfinite(bend)) bends.push_back(bend);
    }
    if (bends.empty()) return;
    noise_ = kNoise * Median(bends);
  }

  bool Has(int t) const { return t >= 0 && t < at_.rows() && !at_.row(t).hasNaN(); }

  // Whether the step from t to t + 1 (both present) exceeds `share` of the limits.
  bool IsBeyond(double share, int t) const {
    const Point step = at_.row(t + 1) - at_.row(t);
    if (step.norm() > share * Reach(1)) return true;
    const double limit = share * MaxDeviation(1);
    const bool has_before = Has(t - 1);
    const bool has_after = Has(t + 2);
    const Point before = has_before ? Point(step - (at_.row(t) - at_.row(t - 1))) : Point(0, 0, 0);
    const Point after =
        has_after ? Point(step - (at_.row(t + 2) - at_.row(t + 1))) : Point(0, 0, 0);
    if (!has_before || !has_after) return before.norm() + after.norm() > limit;
    const double minimum = std::min(before.norm(), after.norm());
    return before.dot(after) > 0 && minimum > limit / 2 && before.norm() + after.norm() > 2 * limit;
  }

  // Whether a body can get from `from`, the end of a piece, to `to`, the start of a later piece.
  bool Leads(int from, bool has_before, int to, bool has_after) const {
    const int steps = to - from;
    const Point displacement = at_.row(to) - at_.row(from);
    if (displacement.norm() > Reach(steps)) return false;
    if (!has_before || !has_after) return true;
    const Point before = at_.row(from) - at_.row(from - 1);
    const Point after = at_.row(to + 1) - at_.row(to);
    return (displacement - 0.5 * steps * (before + after)).norm() <= MaxDeviation(steps);
  }

 private:
  double Reach(int steps) const { return limits_.speed * steps * dt_ + noise_; }
  double MaxDeviation(int steps) const {
    const double seconds = steps * dt_;
    return std::max(limits_.min_deviation, std::min(limits_.acceleration * seconds * seconds,
                                                    limits_.velocity_change * seconds)) +
           steps * noise_;
  }

  const MarkerPath& at_;
  const double dt_;
  const PathLimits limits_;
  double noise_ = 0;
};

struct Piece {
  int first = 0;
  int last = 0;
  bool after_break = false;    // the step from the previous piece is impossible
  bool after_suspect = false;  // that step is possible, but near the limits
  double weight = 0;
  double best = 0;  // weight of the best chain that ends here
  int before = -1;
};

std::vector<Piece> CutIntoPieces(const Path& path, int frames,
                                 const std::vector<FrameSpan>& doubtful,
                                 std::vector<int>& suspects) {
  std::vector<bool> begins(static_cast<std::size_t>(frames) + 1);
  std::vector<bool> is_doubtful(frames);
  for (const FrameSpan& range : doubtful) {
    begins[range.first] = true;
    begins[range.last + 1] = true;
    std::fill(is_doubtful.begin() + range.first, is_doubtful.begin() + range.last + 1, true);
  }
  std::vector<Piece> pieces;
  for (int t = 0; t < frames; ++t) {
    if (!path.Has(t)) continue;
    const bool follows = path.Has(t - 1);
    const bool may_break = follows && path.IsBeyond(kSuspect, t - 1);
    const bool is_break = may_break && path.IsBeyond(1, t - 1);
    if (may_break) suspects.push_back(t);
    if (!follows || may_break || begins[t])
      pieces.push_back({t, t, is_break, may_break && !is_break});
    Piece& piece = pieces.back();
    piece.last = t;
    piece.weight += is_doubtful[t] ? kDoubtfulWeight : 1;
  }
  return pieces;
}

bool Follows(const Path& path, const Piece& before, const Piece& piece) {
  if (before.last + 1 == piece.first) return !piece.after_break;
  return path.Leads(before.last, before.last > before.first, piece.first, piece.last > piece.first);
}

// Cost, in frames, of a chain that skips the pieces between two: 0 after an impossible step, more
// than their weight after a suspect step. Skipping them is still better than losing all that
// follows.
double SkipCost(const std::vector<Piece>& pieces, int before, int piece) {
  constexpr double kMinCost = 8;
  if (before + 1 == piece) return 0;
  const bool suspect = pieces[piece].after_suspect || pieces[before + 1].after_suspect;
  return suspect ? kMinCost + 2.0 * (pieces[piece].first - pieces[before].last - 1) : 0;
}

}  // namespace

std::vector<FrameSpan> StillRuns(const MarkerPath& path, double frame_rate_hz) {
  const int minimum =
      std::max(kStillFrames, static_cast<int>(std::ceil(kStillSeconds * frame_rate_hz)));
  std::vector<FrameSpan> runs;
  const auto frames = static_cast<int>(path.rows());
  for (int first = 0, t = 1; t <= frames; ++t) {
    if (t < frames && path.row(t) == path.row(first)) continue;
    if (t - first >= minimum) runs.push_back({first, t - 1});
    first = t;
  }
  return runs;
}

PathFaults FindPathFaults(const MarkerPath& at, double frame_rate_hz, const PathLimits& limits,
                          const std::vector<FrameSpan>& doubtful) {
  const Path path(at, frame_rate_hz, limits);
  PathFaults faults;
  std::vector<Piece> pieces =
      CutIntoPieces(path, static_cast<int>(at.rows()), doubtful, faults.suspects);
  if (pieces.empty()) return faults;
  int end = 0;
  for (int i = 0; i < std::ssize(pieces); ++i) {
    Piece& piece = pieces[i];
    piece.best = piece.weight;
    for (int j = i - 1; j >= 0 && j >= i - kPiecesBack; --j) {
      const double chain = pieces[j].best + piece.weight - SkipCost(pieces, j, i);
      if (chain > piece.best && Follows(path, pieces[j], piece)) {
        piece.best = chain;
        piece.before = j;
      }
    }
    if (piece.best > pieces[end].best) end = i;
  }
  std::vector<bool> in_chain(pieces.size());
  for (int i = end; i >= 0; i = pieces[i].before) in_chain[i] = true;
  std::vector<FrameSpan>& outside = faults.outside;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (in_chain[i]) continue;
    const bool adjoins = !outside.empty() && outside.back().last + 1 == pieces[i].first;
    if (adjoins) {
      outside.back().last = pieces[i].last;
    } else {
      outside.push_back({pieces[i].first, pieces[i].last});
    }
  }
  return faults;
}

namespace {

constexpr int kMaxSamples = 200;         // frames for learning distances
constexpr std::size_t kMaxPartners = 3;  // of a marker
constexpr std::size_t kMinPartners = 2;
constexpr float kNear = 0.5F;  // leg lengths
constexpr double kUsualQuantile = 0.95;
constexpr float kRigid = 0.04F;   // leg lengths
constexpr float kWrong = 0.1F;    // leg lengths
constexpr float kVariations = 4;  // of a distance

struct Partner {
  int marker = 0;
  float distance = 0;   // m
  float variation = 0;  // m
};

float DistanceAt(const MarkerMotion& motion, Eigen::Index frame, int a, int b) {
  const auto row = motion.positions_m.row(frame);
  return (row.segment<3>(3 * a) - row.segment<3>(3 * b)).norm();
}

std::ptrdiff_t NearestRank(const std::vector<float>& values, double share) {
  return static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
}

// Whether the value of NearestRank is at most `limit`, in a fraction of its time.
bool QuantileIsAtMost(const std::vector<float>& values, double share, float limit) {
  const auto count =
      std::count_if(values.begin(), values.end(), [limit](float value) { return value <= limit; });
  return count > NearestRank(values, share);
}

// Returns `other` as a partner of `marker` if it is near and at constant distance. Most pairs are
// not.
std::optional<Partner> FindPartner(const MarkerMotion& motion, int marker, int other,
                                   float leg_length_m) {
  const Eigen::Index frames = motion.positions_m.rows();
  const Eigen::Index samples = std::min<Eigen::Index>(frames, kMaxSamples);
  std::vector<float> distances;
  distances.reserve(static_cast<std::size_t>(samples));
  for (Eigen::Index i = 0; i < samples; ++i) {
    const float distance = DistanceAt(motion, i * frames / samples, marker, other);
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  if (distances.empty() || !QuantileIsAtMost(distances, 0.5, kNear * leg_length_m)) {
    return std::nullopt;
  }
  const float median = ValueOfRank(distances, NearestRank(distances, 0.5));
  for (float& distance : distances) distance = std::abs(distance - median);
  if (!QuantileIsAtMost(distances, kUsualQuantile, kRigid * leg_length_m)) return std::nullopt;
  return Partner{other, median, ValueOfRank(distances, NearestRank(distances, kUsualQuantile))};
}

using Partners = std::vector<std::vector<Partner>>;

// Returns the nearest markers at constant distance from each marker; none if there are too few.
Partners FindPartners(const MarkerMotion& motion, float leg_length_m) {
  const auto markers = static_cast<int>(motion.names.size());
  Partners partners(markers);
  for (int a = 0; a < markers; ++a) {
    for (int b = 0; b < a; ++b) {
      std::optional<Partner> partner = FindPartner(motion, a, b, leg_length_m);
      if (!partner) continue;
      partners[a].push_back(*partner);
      partner->marker = a;
      partners[b].push_back(*partner);
    }
  }
  for (std::vector<Partner>& list : partners) {
    std::ranges::stable_sort(list, {}, &Partner::distance);
    list.resize(list.size() < kMinPartners ? 0 : std::min(list.size(), kMaxPartners));
  }
  return partners;
}

// Returns the sum of the wrong distances of one marker in a frame; 0 unless two are wrong, or the
// only one that is left. Ignores markers at fault.
float FaultOf(const MarkerMotion& motion, Eigen::Index frame, int marker,
              const std::vector<Partner>& partners, const std::vector<std::uint8_t>& at_fault,
              float leg_length_m) {
  float fault = 0;
  std::size_t wrong = 0;
  std::size_t checked = 0;
  for (const Partner& partner : partners) {
    if (at_fault[partner.marker] != 0) continue;
    ++checked;
    const float off =
        std::abs(DistanceAt(motion, frame, marker, partner.marker) - partner.distance);
    if (!(off > std::max(kWrong * leg_length_m, kVariations * partner.variation))) continue;
    fault += off;
    ++wrong;
  }
  return wrong >= std::min(kMinPartners, checked) ? fault : 0;
}

}  // namespace

std::vector<std::vector<FrameSpan>> FramesOffSegment(const MarkerMotion& motion,
                                                     double leg_length_m) {
  const auto leg = static_cast<float>(leg_length_m);
  const Partners partners = FindPartners(motion, leg);
  std::vector<std::vector<FrameSpan>> off(partners.size());
  std::vector<std::uint8_t> at_fault(partners.size());
  for (int t = 0; t < motion.positions_m.rows(); ++t) {
    std::ranges::fill(at_fault, 0);
    while (true) {
      float max_fault = 0;
      std::size_t worst = 0;
      for (std::size_t m = 0; m < partners.size(); ++m) {
        if (at_fault[m] != 0 || partners[m].empty()) continue;
        const float fault = FaultOf(motion, t, static_cast<int>(m), partners[m], at_fault, leg);
        if (fault > max_fault) {
          max_fault = fault;
          worst = m;
        }
      }
      if (max_fault == 0) break;
      at_fault[worst] = 1;
      if (!off[worst].empty() && off[worst].back().last + 1 == t) {
        off[worst].back().last = t;
      } else {
        off[worst].push_back({t, t});
      }
    }
  }
  return off;
}

}  // namespace motiondb::core
