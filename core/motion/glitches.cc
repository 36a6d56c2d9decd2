#include "core/motion/glitches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/motion/marker_path.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr PathLimits kMarkerLimits{40, 1200, 25, 0.2};  // leg lengths, see the header
constexpr PathLimits kBodyLimits{40, 180, 15, 0.2};
constexpr double kBeyond_m = 1e5;
constexpr double kBridgedSeconds = 0.25;  // as kMaxRepairSeconds

PathLimits InMetres(const PathLimits& limits, double leg_length_m) {
  return {leg_length_m * limits.speed, leg_length_m * limits.acceleration,
          leg_length_m * limits.velocity_change, leg_length_m * limits.min_deviation};
}

MarkerPath PathOf(const MarkerMotion& motion, int marker) {
  return motion.positions_m.middleCols<3>(3 * static_cast<Eigen::Index>(marker)).cast<double>();
}

// Path of the body as a whole: each step is the median of the markers' steps, by coordinate.
MarkerPath BodyPath(const MarkerMotion& motion) {
  const Eigen::Index frames = motion.positions_m.rows();
  MarkerPath path = MarkerPath::Zero(frames, 3);
  std::vector<double> steps;
  for (Eigen::Index t = 1; t < frames; ++t) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      steps.clear();
      for (Eigen::Index c = axis; c < motion.positions_m.cols(); c += 3) {
        const double step = static_cast<double>(motion.positions_m(t, c)) -
                            static_cast<double>(motion.positions_m(t - 1, c));
        if (std::abs(step) < kBeyond_m) steps.push_back(step);  // false for NaN
      }
      path(t, axis) = path(t - 1, axis);
      if (!steps.empty()) path(t, axis) += Median(steps);
    }
  }
  return path;
}

// Returns the frames for which `holds` returns true, as runs.
template <typename Holds>
std::vector<FrameSpan> RunsWhere(int frames, const Holds& holds) {
  std::vector<FrameSpan> runs;
  for (int t = 0; t < frames; ++t) {
    if (!holds(t)) continue;
    if (runs.empty() || runs.back().last + 1 < t) runs.push_back({t, t});
    runs.back().last = t;
  }
  return runs;
}

// Returns the first of `ranges` (ascending, disjoint) that ends at or after the start of `range`:
// the only one that can contain it.
std::vector<FrameSpan>::const_iterator FirstCandidate(const FrameSpan& range,
                                                      const std::vector<FrameSpan>& ranges) {
  return std::ranges::lower_bound(ranges, range.first, {}, &FrameSpan::last);
}

bool OverlapsAny(const FrameSpan& range, const std::vector<FrameSpan>& ranges) {
  const auto candidate = FirstCandidate(range, ranges);
  return candidate != ranges.end() && candidate->first <= range.last;
}

bool IsWithinAny(const FrameSpan& range, const std::vector<FrameSpan>& ranges) {
  const auto candidate = FirstCandidate(range, ranges);
  return candidate != ranges.end() && candidate->first <= range.first &&
         range.last <= candidate->last;
}

// Selects the off-segment spans that begin or end abruptly: in a calm clip limbs change their
// distances too, but smoothly. `suspects`: frames after a suspect step. A span with one abrupt end
// is extended to a suspect step at the other end if its length stays within `max_frames`, because
// distances between may be right by chance.
std::vector<FrameSpan> AbruptSpans(const std::vector<FrameSpan>& spans,
                                   const std::vector<int>& suspects, int max_frames) {
  std::vector<FrameSpan> abrupt;
  for (FrameSpan span : spans) {
    const auto begins = std::ranges::lower_bound(suspects, span.first);
    const auto ends = std::ranges::lower_bound(suspects, span.last + 1);
    const bool begins_abruptly = begins != suspects.end() && *begins == span.first;
    const bool ends_abruptly = ends != suspects.end() && *ends == span.last + 1;
    if (!begins_abruptly && !ends_abruptly) continue;
    if (!ends_abruptly && ends != suspects.end() && *ends - span.first <= max_frames) {
      span.last = *ends - 1;
    }
    if (!begins_abruptly && begins != suspects.begin() &&
        span.last - *std::prev(begins) < max_frames) {
      span.first = *std::prev(begins);
    }
    if (!abrupt.empty() && span.first <= abrupt.back().last + 1) {
      abrupt.back().last = std::max(abrupt.back().last, span.last);
    } else {
      abrupt.push_back(span);
    }
  }
  return abrupt;
}

class Search {
 public:
  Search(const MarkerMotion& motion, double leg_length_m, const Eigen::Vector2d& origin)
      : motion_(motion),
        leg_length_m_(leg_length_m),
        origin_(-origin.x(), -origin.y(), 0),
        off_segment_(FramesOffSegment(motion, leg_length_m)) {}

  std::vector<Glitch> Run() {
    SearchBody();
    for (int m = 0; m < static_cast<int>(motion_.names.size()); ++m) SearchMarker(m);
    return InOrder();
  }

 private:
  int frames() const { return static_cast<int>(motion_.positions_m.rows()); }

  void Add(int marker, const FrameSpan& range, GlitchKind kind) {
    found_.push_back({marker, range.first, range.last, kind});
  }

  void SearchBody() {
    const MarkerPath path = BodyPath(motion_);
    const std::vector<FrameSpan> still = StillRuns(path, motion_.frame_rate_hz);
    body_faults_ =
        FindPathFaults(path, motion_.frame_rate_hz, InMetres(kBodyLimits, leg_length_m_), still)
            .outside;
    for (const FrameSpan& range : body_faults_) {
      Add(Glitch::kAllMarkers, range,
          IsWithinAny(range, still) ? GlitchKind::kFrozen : GlitchKind::kJump);
    }
  }

  void SearchMarker(int marker) {
    MarkerPath path = PathOf(motion_, marker);
    const auto beyond =
        RunsWhere(frames(), [&](int t) { return (path.row(t).array().abs() > kBeyond_m).any(); });
    for (const FrameSpan& range : beyond) {
      Add(marker, range, GlitchKind::kBeyond);
      path.middleRows(range.first, range.last - range.first + 1)
          .setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    const auto at_origin = RunsWhere(frames(), [&](int t) { return path.row(t) == origin_; });
    const auto still = StillRuns(path, motion_.frame_rate_hz);
    std::vector<FrameSpan> doubtful = at_origin;
    doubtful.insert(doubtful.end(), still.begin(), still.end());
    const auto [outside, suspects] = FindPathFaults(
        path, motion_.frame_rate_hz, InMetres(kMarkerLimits, leg_length_m_), doubtful);
    for (const FrameSpan& range : outside) {
      if (IsWithinAny(range, body_faults_)) continue;
      Add(marker, range,
          OverlapsAny(range, at_origin) ? GlitchKind::kOrigin
          : OverlapsAny(range, still)   ? GlitchKind::kFrozen
                                        : GlitchKind::kJump);
    }
    const auto bridged = static_cast<int>(kBridgedSeconds * motion_.frame_rate_hz);
    for (FrameSpan range : AbruptSpans(off_segment_[marker], suspects, bridged)) {
      // A marker that freezes while its segment moves is at fault from the frame in which it froze.
      const auto frozen_run = FirstCandidate(range, still);
      const bool froze = frozen_run != still.end() && frozen_run->first <= range.last;
      if (froze) {
        range = {std::min(range.first, frozen_run->first), std::max(range.last, frozen_run->last)};
      }
      if (IsWithinAny(range, outside) || IsWithinAny(range, body_faults_) ||
          OverlapsAny(range, beyond)) {
        continue;
      }
      Add(marker, range,
          OverlapsAny(range, at_origin) ? GlitchKind::kOrigin
          : froze                       ? GlitchKind::kFrozen
                                        : GlitchKind::kStretched);
    }
  }

  Eigen::RowVector3f At(int frame, int marker) const {
    return motion_.positions_m.row(frame).segment<3>(3 * static_cast<Eigen::Index>(marker));
  }

  // Whether two markers exchange their positions.
  bool Swap(const Glitch& a, const Glitch& b) const {
    const int t = a.first_frame;
    const float crosswise = (At(t, a.marker) - At(t - 1, b.marker)).norm() +
                            (At(t, b.marker) - At(t - 1, a.marker)).norm();
    const float straight = (At(t, a.marker) - At(t - 1, a.marker)).norm() +
                           (At(t, b.marker) - At(t - 1, b.marker)).norm();
    return crosswise < straight / 2;
  }

  using Glitches = std::vector<Glitch>;

  // Marks swapped pairs among glitches that begin in the same frame.
  void MarkSwapped(Glitches::iterator begin, Glitches::iterator end) const {
    if (begin->first_frame == 0) return;
    for (auto a = begin; a != end; ++a) {
      if (a->marker < 0 || a->kind == GlitchKind::kOrigin) continue;
      const auto b = std::find_if(begin, end, [&](const Glitch& other) {
        return other.marker >= 0 && other.marker != a->marker && Swap(*a, other);
      });
      if (b == end) continue;
      a->kind = GlitchKind::kSwapped;
      a->swapped_with = b->marker;
    }
  }

  // Merges glitches in the same frames: if half of the markers have one, all markers have it.
  void Add(Glitches::iterator begin, Glitches::iterator end, Glitches& merged) const {
    if (end - begin == 1 || 2 * (end - begin) < std::ssize(motion_.names)) {
      merged.insert(merged.end(), begin, end);
      return;
    }
    const bool swapped = begin->kind == GlitchKind::kSwapped;
    merged.push_back({Glitch::kAllMarkers, begin->first_frame, begin->last_frame,
                      swapped ? GlitchKind::kJump : begin->kind});
  }

  // Returns the glitches ordered by frame and marker.
  Glitches InOrder() {
    std::ranges::sort(found_, {}, [](const Glitch& g) {
      return std::tuple(g.first_frame, g.last_frame, g.marker);
    });
    const auto each = [&](const auto& key, const auto& body) {
      for (auto begin = found_.begin(); begin != found_.end();) {
        const auto end = std::find_if(
            begin, found_.end(), [&](const Glitch& other) { return key(other) != key(*begin); });
        body(begin, end);
        begin = end;
      }
    };
    each([](const Glitch& g) { return g.first_frame; },
         [&](auto begin, auto end) { MarkSwapped(begin, end); });
    Glitches merged;
    each([](const Glitch& g) { return std::pair(g.first_frame, g.last_frame); },
         [&](auto begin, auto end) { Add(begin, end, merged); });
    return merged;
  }

  const MarkerMotion& motion_;
  const double leg_length_m_;
  const Eigen::RowVector3d origin_;
  const std::vector<std::vector<FrameSpan>> off_segment_;
  std::vector<FrameSpan> body_faults_;
  std::vector<Glitch> found_;
};

}  // namespace

std::vector<Glitch> FindGlitches(const MarkerMotion& motion, double leg_length_m,
                                 const Eigen::Vector2d& origin) {
  return Search(motion, leg_length_m, origin).Run();
}

std::string Describe(const Glitch& glitch, const MarkerMotion& motion) {
  const int first = motion.first_frame + glitch.first_frame + 1;
  const int last = motion.first_frame + glitch.last_frame + 1;
  const std::string frames =
      first == last ? fmt::format("frame {}", first) : fmt::format("frames {}-{}", first, last);
  const bool all = glitch.marker == Glitch::kAllMarkers;
  const std::string subject =
      all ? "all markers" : fmt::format("'{}'", motion.names[glitch.marker]);
  const auto verb = [&](const char* one, const char* many) {
    return fmt::format("{}: {} {}", frames, subject, all ? many : one);
  };
  switch (glitch.kind) {
    case GlitchKind::kOrigin:
      return verb("is at the origin", "are at the origin");
    case GlitchKind::kFrozen:
      return verb("is frozen", "are frozen");
    case GlitchKind::kSwapped:
      return fmt::format("{}: {} is swapped with '{}'", frames, subject,
                         motion.names[glitch.swapped_with]);
    case GlitchKind::kStretched:
      return verb("leaves its segment", "leave their segments");
    case GlitchKind::kBeyond:
      return verb("is beyond 100 km", "are beyond 100 km");
    case GlitchKind::kJump:
      break;
  }
  return verb("jumps", "jump");
}

}  // namespace motiondb::core
