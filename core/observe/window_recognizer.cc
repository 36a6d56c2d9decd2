#include "core/observe/window_recognizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/model/familiarity.h"
#include "core/model/metric_frames.h"
#include "core/motion/error.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/clip_generation.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/noise_energy.h"
#include "core/recognition/unknown.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kKeptClips = 80;
constexpr double kLogZero = -std::numeric_limits<double>::infinity();

}  // namespace

WindowRecognizer::WindowRecognizer(const Model& model, int window_frames, double transition_floor)
    : model_(model),
      window_frames_(window_frames),
      transition_floor_(transition_floor),
      labels_(Labels(model)),
      ranking_(static_cast<int>(model.clips().size())) {
  for (int c = 0; c < static_cast<int>(model.clips().size()); ++c) {
    label_of_clip_.push_back(static_cast<int>(LabelIndex(model, labels_, c)));
  }
  if (!model.metric().empty()) window_.emplace(model, window_frames);
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
  MOTIONDB_ASSIGN_OR_RETURN(
      auto windows, core::Recognize(model_, states.Last(Width(states)), options, cancelled));
  RecognizedWindow& window = windows.front();
  return Answer{std::move(window.labels), window.unknown_probability, window.familiarity};
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
  WindowEmission emission(model_, layer, scaled, static_cast<int>(scaled.rows()));
  emission.MoveTo(0);
  return model_.familiarity().Rank(
      layer, core::FamiliarityScore(model_.global_graph(layer), emission.log_density()));
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
  shortlist_ = ranking_.TakeShortlist({});
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

double WindowRecognizer::LogEvidence(const CachedClip& clip) {
  double log_evidence = 0;
  if (clip.LogEvidence(rings_, paths_, log_evidence)) return log_evidence;
  FrameMatrix observed(frames_.size(), model_.metric().projection.cols());
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    observed.row(static_cast<Eigen::Index>(i)) = window_->Kept(frames_[i]).projected.transpose();
  }
  return AlignToClip(model_.metric_frames(), clip.clip(), observed, false).log_evidence;
}

std::vector<ClipEvidence> WindowRecognizer::DecisiveClips() {
  struct Bounded {
    double upper_bound;
    std::size_t place;  // index in the shortlist
  };
  std::vector<Bounded> order;
  std::vector<double> best(labels_.size(), kLogZero);
  std::vector<bool> is_listed(labels_.size());
  for (std::size_t place = 0; place < listed_.size(); ++place) {
    order.push_back({listed_[place]->LogEvidenceBound(rings_), place});
    is_listed[label_of_clip_[shortlist_[place]]] = true;
  }
  std::ranges::sort(order, std::ranges::greater(), &Bounded::upper_bound);
  // A label without a listed clip gets the evidence of the poorest clip, so all clips count.
  const bool all_listed = std::ranges::find(is_listed, false) == is_listed.end();
  std::vector<ClipEvidence> decisive;
  for (const auto& [upper_bound, place] : order) {
    double& of_label = best[label_of_clip_[shortlist_[place]]];
    if (all_listed && upper_bound <= of_label) continue;
    decisive.push_back({shortlist_[place], LogEvidence(*listed_[place])});
    of_label = std::max(of_label, decisive.back().log_evidence);
  }
  return decisive;
}

double WindowRecognizer::Energy() const {
  double sum = 0;
  for (const std::int64_t frame : frames_) sum += window_->Kept(frame).squared_norm;
  return sum / static_cast<double>(frames_.size());
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
  const WindowAlignment alignment{.clips = DecisiveClips(),
                                  .frames = static_cast<int>(frames_.size()),
                                  .energy = Energy(),
                                  .noise = Noise(states)};
  LabelAnswer labels = LabelsOrUnknown(model_, labels_, alignment, calibration);
  Answer answer{std::move(labels.labels), labels.unknown_probability, 0};
  answer.familiarity = calibration.familiarity.empty()
                           ? FamiliarityByGraph(states)
                           : calibration.FamiliarityRank(FamiliarityScore());
  return answer;
}

}  // namespace motiondb::core
