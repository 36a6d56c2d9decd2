#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/glitches.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kMaxDescribed = 8;  // glitches in a note

// Returns the spans in order; spans that overlap or touch are joined.
std::vector<FrameSpan> Joined(std::vector<FrameSpan> spans) {
  std::ranges::sort(spans, {}, &FrameSpan::first);
  std::vector<FrameSpan> joined;
  for (const FrameSpan& span : spans) {
    if (!joined.empty() && span.first <= joined.back().last + 1) {
      joined.back().last = std::max(joined.back().last, span.last);
    } else {
      joined.push_back(span);
    }
  }
  return joined;
}

std::vector<FrameSpan> SpansOf(const std::vector<Glitch>& glitches) {
  std::vector<FrameSpan> spans;
  spans.reserve(glitches.size());
  for (const Glitch& glitch : glitches) spans.push_back({glitch.first_frame, glitch.last_frame});
  return Joined(std::move(spans));
}

std::string Note(const char* what, const std::vector<Glitch>& glitches,
                 const MarkerMotion& motion) {
  std::string note = std::string(kGlitchNote) + what + " (" + std::to_string(glitches.size()) + ")";
  for (std::size_t i = 0; i < std::min(glitches.size(), kMaxDescribed); ++i) {
    note += (i == 0 ? ": " : ", ") + Describe(glitches[i], motion);
  }
  return glitches.size() > kMaxDescribed ? note + ", ..." : note;
}

absl::Status Refusal(const Glitch& glitch, const std::vector<Glitch>& glitches,
                     const MarkerMotion& motion, const std::string& reason) {
  return InvalidArgument("{} ({} glitches in total): {}", Describe(glitch, motion), glitches.size(),
                         reason);
}

absl::Status Repair(const std::vector<Glitch>& glitches, MarkerMotion& motion) {
  const auto markers = static_cast<int>(motion.names.size());
  std::vector<std::vector<FrameSpan>> of_marker(motion.names.size());
  for (const Glitch& glitch : glitches) {
    const bool all = glitch.marker == Glitch::kAllMarkers;
    for (int m = all ? 0 : glitch.marker; m < (all ? markers : glitch.marker + 1); ++m) {
      of_marker[m].push_back({glitch.first_frame, glitch.last_frame});
    }
  }
  for (int m = 0; m < markers; ++m) {
    for (const FrameSpan& span : Joined(std::move(of_marker[m]))) {
      const int frames = span.last - span.first + 1;
      if (frames > kMaxRepairSeconds * motion.frame_rate_hz) {
        // Describe the span by its first glitch.
        const auto first = std::ranges::find_if(glitches, [&](const Glitch& glitch) {
          return glitch.first_frame == span.first &&
                 (glitch.marker == m || glitch.marker == Glitch::kAllMarkers);
        });
        return Refusal(
            *first, glitches, motion,
            fmt::format("repair is limited to {:.2f} s, this lasts {:.2f} s; set --glitches "
                        "drop or keep on the database, or cut the file",
                        kMaxRepairSeconds, frames / motion.frame_rate_hz));
      }
      motion.positions_m.block(span.first, 3 * static_cast<Eigen::Index>(m), frames, 3)
          .setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  }
  return absl::OkStatus();
}

// Returns the longest part between spans; empty (last < first) if there is none.
FrameSpan LongestBetween(const std::vector<FrameSpan>& spans, int frames) {
  FrameSpan longest{0, -1};
  int first = 0;
  const auto consider = [&](int end) {
    if (end - first > longest.last - longest.first + 1) longest = {first, end - 1};
  };
  for (const FrameSpan& span : spans) {
    consider(span.first);
    first = span.last + 1;
  }
  consider(frames);
  return longest;
}

}  // namespace

absl::StatusOr<std::vector<FrameSpan>> ApplyGlitchPolicy(GlitchPolicy policy,
                                                         const std::vector<Glitch>& glitches,
                                                         MarkerMotion& motion,
                                                         std::vector<std::string>& notes) {
  if (glitches.empty()) return std::vector<FrameSpan>{};
  switch (policy) {
    case GlitchPolicy::kReject:
      return Refusal(glitches.front(), glitches, motion,
                     "the database rejects clips with glitches");
    case GlitchPolicy::kRepair:
      MOTIONDB_RETURN_IF_ERROR(Repair(glitches, motion));
      notes.push_back(Note("repaired", glitches, motion));
      return std::vector<FrameSpan>{};
    case GlitchPolicy::kKeep:
      notes.push_back(Note("kept", glitches, motion));
      return SpansOf(glitches);
    case GlitchPolicy::kDrop:
      break;
  }
  const auto frames = static_cast<int>(motion.positions_m.rows());
  const FrameSpan longest = LongestBetween(SpansOf(glitches), frames);
  const int remaining = longest.last - longest.first + 1;
  if (remaining < 2)
    return Refusal(glitches.front(), glitches, motion,
                   "fewer than 2 frames remain without glitches");
  const std::string cut =
      fmt::format("dropped, frames {}-{} of {} stored", motion.first_frame + longest.first + 1,
                  motion.first_frame + longest.last + 1, motion.first_frame + frames);
  notes.push_back(Note(cut.c_str(), glitches, motion));
  motion.positions_m = motion.positions_m.middleRows(longest.first, remaining).eval();
  motion.first_frame += longest.first;
  return std::vector<FrameSpan>{};
}

std::vector<FrameSpan> AtFrameRate(const std::vector<FrameSpan>& spans, double from_hz,
                                   double to_hz, int frame_count) {
  constexpr int kNeighbours = 2;  // of cubic interpolation; one more for velocities
  const double rate = to_hz / from_hz;
  std::vector<FrameSpan> affected;
  for (const FrameSpan& span : spans) {
    const auto first = static_cast<int>(std::floor((span.first - kNeighbours) * rate)) - 1;
    const auto last = static_cast<int>(std::ceil((span.last + kNeighbours) * rate)) + 1;
    affected.push_back(
        {std::clamp(first, 0, frame_count - 1), std::clamp(last, 0, frame_count - 1)});
  }
  return Joined(std::move(affected));
}

}  // namespace motiondb::core
