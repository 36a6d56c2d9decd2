#include "core/observe/window_recognizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/model/metric_frames.h"
#include "core/motion/error.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/clip_generation.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/unknown.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kKeptClips = 80;
constexpr double kLogZero = -std::numeric_limits<double>::infinity();

}  // namespace

WindowRecognizer::WindowRecognizer(const Model& model, int window_frames, double transition_floor,
                                   std::shared_ptr<const ClipMask> mask, std::string track)
    : model_(model),
      window_frames_(window_frames),
      transition_floor_(transition_floor),
      mask_(std::move(mask)),
      track_(std::move(track)),
      units_(UnitsOf(model, track_, mask_.get())),
      ranking_(static_cast<int>(model.clips().size())) {
  if (!model.metric().empty()) window_.emplace(model, mask_.get(), window_frames);
  clips_.reserve(kKeptClips);
}

void WindowRecognizer::Restart() {
  if (window_) window_->Restart();
  clips_.clear();
}

int WindowRecognizer::Width(const ObservedStates& states) const {
  return std::min(window_frames_, states.kept());
}

absl::StatusOr<WindowRecognizer::Answer> WindowRecognizer::Whole(const ObservedStates& states,
                                                                 const Cancelled& cancelled) const {
  RecognizeOptions options;
  options.window_seconds = Width(states) / model_.settings().frame_rate_hz;
  options.transition_floor = transition_floor_;
  options.mask = mask_;
  options.track = track_;
  MOTIONDB_ASSIGN_OR_RETURN(
      auto windows, core::Recognize(model_, states.Last(Width(states)), options, cancelled));
  RecognizedWindow& window = windows.front();
  return Answer{std::move(window.labels), window.unknown_probability, window.familiarity,
                std::move(window.other_tracks)};
}

bool WindowRecognizer::ShowsAll(const ObservedStates& states) const {
  const std::int64_t newest = states.next() - 1;
  const auto is_missing = [&](std::int64_t frame, Eigen::Index d) {
    return std::isnan(states.state(frame)[d]);
  };
  for (Eigen::Index d = 0; d < states.state(newest).size(); ++d) {
    std::int64_t frame = newest;
    while (frame > newest - Width(states) && is_missing(frame, d)) --frame;
    if (frame == newest - Width(states)) return false;
  }
  return true;
}

double WindowRecognizer::FamiliarityByGraph(const ObservedStates& states) const {
  FrameMatrix scaled = states.Last(Width(states)).states;
  model_.scale().Apply(scaled);
  const int layer = model_.layer_count();
  WindowEmission emission(model_, layer, scaled, static_cast<int>(scaled.rows()), mask_.get());
  emission.MoveTo(0);
  return emission.Familiarity();
}

void WindowRecognizer::ChooseFrames(const ObservedStates& states) {
  const int width = Width(states);
  const int stride = FrameStride(model_.settings().frame_rate_hz);
  frames_.clear();
  rings_.clear();
  for (const int frame : ComparedFrames(0, width, stride, false)) {
    frames_.push_back(states.next() - width + frame);
    rings_.push_back(static_cast<std::size_t>(frames_.back() % window_frames_));
  }
}

CachedClip& WindowRecognizer::Keep(int clip) {
  auto cached = std::ranges::find(clips_, clip, &CachedClip::clip);
  if (cached == clips_.end()) {
    if (clips_.size() < kKeptClips) {
      clips_.emplace_back();
      cached = clips_.end() - 1;
    } else {
      cached = std::ranges::min_element(clips_, {}, &CachedClip::last_used);
    }
    cached->Take(model_, clip, window_frames_);
  }
  cached->last_used = answers_;
  return *cached;
}

absl::Status WindowRecognizer::CompareClips(const ObservedStates& states,
                                            const Cancelled& cancelled) {
  for (const int i : ShortlistFrames(static_cast<int>(frames_.size()))) {
    ranking_.Add(window_->At(states, frames_[i]).near);
  }
  shortlist_ = ranking_.TakeShortlist(mask_.get());
  nearest_.assign(frames_.size(), {std::numeric_limits<float>::infinity(), 0});
  listed_.clear();
  // Check once, not for every clip: a check takes longer than a clip.
  if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
  for (const int clip : shortlist_) {
    CachedClip& cached = Keep(clip);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const NearestFrame& near = cached.Compare(model_, rings_[i], window_->At(states, frames_[i]));
      if (near.squared_distance < nearest_[i].squared_distance) nearest_[i] = near;
    }
    listed_.push_back(&cached);
  }
  return absl::OkStatus();
}

double WindowRecognizer::LogEvidence(const CachedClip& clip, RowRange rows) {
  double log_evidence = 0;
  if (clip.LogEvidence(rows, rings_, paths_, log_evidence)) return log_evidence;
  FrameMatrix observed(frames_.size(), model_.metric().projection.cols());
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    observed.row(static_cast<Eigen::Index>(i)) = window_->Kept(frames_[i]).projected.transpose();
  }
  return AlignToClip(model_.metric_frames(), rows, observed, false).log_evidence;
}

std::vector<UnitEvidence> WindowRecognizer::DecisiveUnits() {
  struct Bounded {
    double upper_bound;
    const CachedClip* clip;
    const LabelUnit* unit;
  };
  std::vector<Bounded> order;
  std::vector<double> best(units_->labels().size(), kLogZero);
  std::vector<bool> is_listed(best.size());
  for (const CachedClip* const clip : listed_) {
    for (const LabelUnit& unit : units_->of_clip(clip->clip())) {
      order.push_back({clip->LogEvidenceBound(unit.rows.count, rings_), clip, &unit});
      if (unit.label >= 0) is_listed[unit.label] = true;
    }
  }
  std::ranges::sort(order, std::ranges::greater(), &Bounded::upper_bound);
  // A label without a listed unit gets the evidence of the poorest unit, so all units count.
  const bool all_count =
      !units_->other_tracks().empty() || std::ranges::find(is_listed, false) != is_listed.end();
  std::vector<UnitEvidence> decisive;
  for (const auto& [upper_bound, clip, unit] : order) {
    if (!all_count && (unit->label < 0 || upper_bound <= best[unit->label])) continue;
    decisive.push_back({unit, LogEvidence(*clip, unit->rows)});
    if (unit->label < 0) continue;
    best[unit->label] = std::max(best[unit->label], decisive.back().log_evidence);
  }
  return decisive;
}

double WindowRecognizer::Noise(const ObservedStates& states) {
  const std::int64_t newest = frames_.back();
  before_newest_.resize(newest - frames_.front(), model_.metric().projection.cols());
  for (Eigen::Index f = 0; f < before_newest_.rows(); ++f) {
    before_newest_.row(f) = window_->Projected(states, frames_.front() + f).projected.transpose();
  }
  return NoiseEnergy(before_newest_);
}

double WindowRecognizer::FamiliarityScore() {
  double sum = 0;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    sum += window_->SquaredDifference(frames_[i], nearest_[i].frame);
  }
  return FamiliarityOfDifference(
      sum / static_cast<double>(frames_.size() * static_cast<std::size_t>(model_.states().cols())));
}

absl::StatusOr<WindowRecognizer::Answer> WindowRecognizer::Recognize(const ObservedStates& states,
                                                                     const Cancelled& cancelled) {
  shortlist_.clear();
  if (!window_ || !ShowsAll(states)) return Whole(states, cancelled);
  ++answers_;
  ChooseFrames(states);
  MOTIONDB_RETURN_IF_ERROR(CompareClips(states, cancelled));
  const AnswerCalibration& calibration = model_.recognition().window;
  const WindowAlignment alignment{
      .units = DecisiveUnits(), .frames = static_cast<int>(frames_.size()), .noise = Noise(states)};
  LabelAnswer labels = LabelsOrUnknown(units_->labels(), alignment, calibration);
  Answer answer{std::move(labels.labels), labels.unknown_probability, 0, {}};
  answer.other_tracks =
      OtherTracks(model_, *units_, alignment.units, calibration.weight.At(alignment.frames),
                  1 - labels.unknown_probability.value_or(0));
  answer.familiarity = calibration.familiarity.empty()
                           ? FamiliarityByGraph(states)
                           : calibration.FamiliarityRank(FamiliarityScore());
  return answer;
}

}  // namespace motiondb::core
