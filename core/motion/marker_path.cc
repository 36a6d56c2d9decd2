#include "core/motion/marker_path.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace motiondb::core {

namespace {

constexpr double kNoise = 5;  // medians of the second difference
constexpr double kStillSeconds = 0.05;
constexpr int kStillFrames = 3;
constexpr double kSuspect = 0.2;          // of the limits
constexpr int kPiecesBack = 64;           // that a piece may follow
constexpr double kDoubtfulWeight = 1e-3;  // of a frame that stands for nothing by itself

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
    const auto middle = bends.begin() + static_cast<std::ptrdiff_t>(bends.size() / 2);
    std::nth_element(bends.begin(), middle, bends.end());
    noise_ = kNoise * *middle;
  }

  bool Has(int t) const { return t >= 0 && t < at_.rows() && !at_.row(t).hasNaN(); }

  // Whether the step from t to t + 1, both of which are there, is more than `share` of what a body
  // makes.
  bool IsBeyond(double share, int t) const {
    const Point step = at_.row(t + 1) - at_.row(t);
    if (step.norm() > share * Reach(1)) return true;
    const double most = share * MostDeviation(1);
    const bool has_before = Has(t - 1);
    const bool has_after = Has(t + 2);
    const Point before = has_before ? Point(step - (at_.row(t) - at_.row(t - 1))) : Point(0, 0, 0);
    const Point after =
        has_after ? Point(step - (at_.row(t + 2) - at_.row(t + 1))) : Point(0, 0, 0);
    if (!has_before || !has_after) return before.norm() + after.norm() > most;
    const double least = std::min(before.norm(), after.norm());
    return before.dot(after) > 0 && least > most / 2 && before.norm() + after.norm() > 2 * most;
  }

  // Whether a body that is at `from`, the end of a piece, can be at `to`, the start of a later one.
  bool Leads(int from, bool has_before, int to, bool has_after) const {
    const int steps = to - from;
    const Point way = at_.row(to) - at_.row(from);
    if (way.norm() > Reach(steps)) return false;
    if (!has_before || !has_after) return true;
    const Point before = at_.row(from) - at_.row(from - 1);
    const Point after = at_.row(to + 1) - at_.row(to);
    return (way - 0.5 * steps * (before + after)).norm() <= MostDeviation(steps);
  }

 private:
  double Reach(int steps) const { return limits_.speed * steps * dt_ + noise_; }
  double MostDeviation(int steps) const {
    const double seconds = steps * dt_;
    return std::max(limits_.least_deviation, std::min(limits_.acceleration * seconds * seconds,
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
  bool after_break = false;    // the step to it from the piece before is impossible
  bool after_suspect = false;  // that step is possible, but near the limits
  double weight = 0;
  double best = 0;  // of the chains that end here
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

// What a chain loses that passes over the pieces between two, in frames: nothing where impossible
// steps set them apart, more than the pieces are worth where suspect ones do. It is then still
// better than to lose all that comes after.
double SkipCost(const std::vector<Piece>& pieces, int before, int piece) {
  constexpr double kLeast = 8;
  if (before + 1 == piece) return 0;
  const bool suspect = pieces[piece].after_suspect || pieces[before + 1].after_suspect;
  return suspect ? kLeast + 2.0 * (pieces[piece].first - pieces[before].last - 1) : 0;
}

}  // namespace

std::vector<FrameSpan> StillRuns(const MarkerPath& path, double frame_rate_hz) {
  const int least =
      std::max(kStillFrames, static_cast<int>(std::ceil(kStillSeconds * frame_rate_hz)));
  std::vector<FrameSpan> runs;
  const auto frames = static_cast<int>(path.rows());
  for (int first = 0, t = 1; t <= frames; ++t) {
    if (t < frames && path.row(t) == path.row(first)) continue;
    if (t - first >= least) runs.push_back({first, t - 1});
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
    const bool goes_on = !outside.empty() && outside.back().last + 1 == pieces[i].first;
    if (goes_on) {
      outside.back().last = pieces[i].last;
    } else {
      outside.push_back({pieces[i].first, pieces[i].last});
    }
  }
  return faults;
}

namespace {

constexpr int kLookedAt = 200;        // frames that distances are learned from, at most
constexpr std::size_t kPartners = 3;  // of a marker, at most
constexpr std::size_t kLeastPartners = 2;
constexpr float kNear = 0.5F;  // leg lengths
constexpr double kUsual = 0.95;
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

float Quantile(std::vector<float>& values, double share) {
  const auto at = values.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Partner DistanceTo(const MarkerMotion& motion, int marker, int other) {
  const Eigen::Index frames = motion.positions_m.rows();
  const Eigen::Index looked_at = std::min<Eigen::Index>(frames, kLookedAt);
  std::vector<float> distances;
  for (Eigen::Index i = 0; i < looked_at; ++i) {
    const float distance = DistanceAt(motion, i * frames / looked_at, marker, other);
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  if (distances.empty()) return {other, 0, std::numeric_limits<float>::infinity()};
  const float median = Quantile(distances, 0.5);
  for (float& distance : distances) distance = std::abs(distance - median);
  return {other, median, Quantile(distances, kUsual)};
}

using Partners = std::vector<std::vector<Partner>>;

// The nearest of those that keep their distance from each marker; none where there are too few.
Partners FindPartners(const MarkerMotion& motion, float leg_length_m) {
  const auto markers = static_cast<int>(motion.names.size());
  Partners partners(markers);
  for (int a = 0; a < markers; ++a) {
    for (int b = 0; b < a; ++b) {
      Partner partner = DistanceTo(motion, a, b);
      if (!(partner.variation <= kRigid * leg_length_m &&
            partner.distance <= kNear * leg_length_m)) {
        continue;
      }
      partners[a].push_back(partner);
      partner.marker = a;
      partners[b].push_back(partner);
    }
  }
  for (std::vector<Partner>& of_one : partners) {
    std::ranges::stable_sort(of_one, {}, &Partner::distance);
    of_one.resize(of_one.size() < kLeastPartners ? 0 : std::min(of_one.size(), kPartners));
  }
  return partners;
}

// By how much the distances of one marker are wrong in a frame, together; 0 unless two of them are,
// or the only one left. Markers at fault are passed over.
float FaultOf(const MarkerMotion& motion, Eigen::Index frame, int marker,
              const std::vector<Partner>& partners, const std::vector<std::uint8_t>& at_fault,
              float leg_length_m) {
  float fault = 0;
  std::size_t wrong = 0;
  std::size_t asked = 0;
  for (const Partner& partner : partners) {
    if (at_fault[partner.marker] != 0) continue;
    ++asked;
    const float off =
        std::abs(DistanceAt(motion, frame, marker, partner.marker) - partner.distance);
    if (!(off > std::max(kWrong * leg_length_m, kVariations * partner.variation))) continue;
    fault += off;
    ++wrong;
  }
  return wrong >= std::min(kLeastPartners, asked) ? fault : 0;
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
      float most = 0;
      std::size_t worst = 0;
      for (std::size_t m = 0; m < partners.size(); ++m) {
        if (at_fault[m] != 0 || partners[m].empty()) continue;
        const float fault = FaultOf(motion, t, static_cast<int>(m), partners[m], at_fault, leg);
        if (fault > most) {
          most = fault;
          worst = m;
        }
      }
      if (most == 0) break;
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
