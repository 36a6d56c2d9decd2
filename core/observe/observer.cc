#include "core/observe/observer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr double kMinKeptSeconds = 1;  // leg length is estimated over them
constexpr double kMaxSeconds = 60;
constexpr int kMaxKept = 1 << 14;  // frames: a minute at 273 Hz
constexpr int kCheckEvery = 64;    // frames between two cancellation checks
constexpr float kMaxPosition_m = 1e5F;
constexpr double kMinLeg_m = 0.01;
constexpr double kMaxLeg_m = 100;       // measured, in any unit
constexpr double kMaxGivenLeg_m = 3;    // of persons and robots
constexpr double kMinLegChange = 0.01;  // minimum relative change that updates the leg length

bool IsLegLength(double length_m) { return length_m >= kMinLeg_m && length_m <= kMaxLeg_m; }

int InFrames(double seconds, double rate) {
  return std::max(1, static_cast<int>(std::round(seconds * rate)));
}

int KeptFrames(const ObserverOptions& options, double rate) {
  return InFrames(std::max({options.window_seconds, options.history_seconds, kMinKeptSeconds}),
                  rate);
}

}  // namespace

absl::Status CheckOptions(const ObserverOptions& options, const BuildSettings& settings) {
  const auto check_seconds = [](std::string_view field, double seconds) {
    if (seconds > 0 && seconds <= kMaxSeconds) return absl::OkStatus();
    return FieldViolation(field, "expected above 0, at most {}, got {}", kMaxSeconds, seconds);
  };
  MOTIONDB_RETURN_IF_ERROR(check_seconds("window_seconds", options.window_seconds));
  MOTIONDB_RETURN_IF_ERROR(check_seconds("history_seconds", options.history_seconds));
  const double rate = settings.frame_rate_hz;
  if (KeptFrames(options, rate) > kMaxKept) {
    const bool window = options.window_seconds >= options.history_seconds;
    return FieldViolation(window ? "window_seconds" : "history_seconds",
                          "expected at most {} frames, {:.3f} s at {} Hz", kMaxKept,
                          kMaxKept / rate, rate);
  }
  return CheckOptions(PredictOptions{.history_seconds = options.history_seconds,
                                     .horizon_seconds = options.horizon_seconds,
                                     .transition_floor = options.transition_floor});
}

Observer::Observer(const Model& model, MarkerSet set, MarkerStream stream, double frame_rate_hz,
                   std::optional<double> leg_length_m, const ObserverOptions& options, int layer)
    : model_(&model),
      options_(options),
      frame_rate_hz_(frame_rate_hz),
      set_(std::move(set)),
      stream_(std::move(stream)),
      states_(set_, model.settings().frame_rate_hz,
              KeptFrames(options, model.settings().frame_rate_hz)),
      has_leg_length_(leg_length_m.has_value()),
      is_measuring_(!has_leg_length_) {
  if (leg_length_m) states_.set_leg_length_m(*leg_length_m);
  UseModel(model, std::move(options_.mask), layer);
}

absl::StatusOr<std::unique_ptr<Observer>> Observer::Create(
    const Model& model, const MarkerScheme& scheme, const std::vector<std::string>& marker_names,
    double frame_rate_hz, std::optional<double> leg_length_m, const ObserverOptions& options) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options, model.settings()));
  if (leg_length_m && !(IsLegLength(*leg_length_m) && *leg_length_m <= kMaxGivenLeg_m)) {
    return FieldViolation("leg_length_m", "expected {} to {} metres, got {}", kMinLeg_m,
                          kMaxGivenLeg_m, *leg_length_m);
  }
  if (scheme.set.markers != model.marker_set().markers) {
    return InvalidArgument("marker set: expected the model's, '{}', got '{}'",
                           model.marker_set().name, scheme.set.name);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const int layer, model.ResolveLayer(options.layer));
  MOTIONDB_ASSIGN_OR_RETURN(
      MarkerStream stream,
      MarkerStream::Create(scheme, marker_names, frame_rate_hz, model.settings().frame_rate_hz));
  return std::unique_ptr<Observer>(new Observer(model, scheme.set, std::move(stream), frame_rate_hz,
                                                leg_length_m, options, layer));
}

void Observer::UseModel(const Model& model, std::shared_ptr<const ClipMask> mask, int layer) {
  filter_ = std::make_unique<NodeFilter>(model, layer, options_.transition_floor, mask.get());
  recognizer_ = std::make_unique<WindowRecognizer>(
      model, InFrames(options_.window_seconds, model.settings().frame_rate_hz),
      options_.transition_floor, mask, options_.track);
  model_ = &model;
  mask_ = std::move(mask);
}

absl::Status Observer::Replace(const Model& model, std::shared_ptr<const ClipMask> mask) {
  if (model.marker_set().markers != model_->marker_set().markers ||
      model.settings().frame_rate_hz != model_->settings().frame_rate_hz) {
    return InvalidArgument("new model: got {} Hz and marker set '{}', expected {} Hz and '{}'",
                           model.settings().frame_rate_hz, model.marker_set().name,
                           model_->settings().frame_rate_hz, model_->marker_set().name);
  }
  const auto layer = model.ResolveLayer(options_.layer);
  UseModel(model, std::move(mask), layer.ok() ? *layer : model.layer_count());
  ReprocessKept();
  return absl::OkStatus();
}

std::optional<double> Observer::leg_length_m() const {
  return has_leg_length_ ? std::optional(states_.leg_length_m()) : std::nullopt;
}

std::optional<Eigen::RowVectorXf> Observer::NewestPositions() const {
  if (states_.kept() == 0) return std::nullopt;
  return states_.LastPositions(1).positions_m.row(0);
}

absl::Status Observer::Append(std::int64_t first_frame, const FrameMatrix& positions_m,
                              const Cancelled& cancelled) {
  if (positions_m.rows() == 0) return absl::OkStatus();
  MOTIONDB_RETURN_IF_ERROR(Check(first_frame, positions_m));
  for (Eigen::Index row = 0; row < positions_m.rows(); ++row) {
    const std::int64_t number = first_frame + row;
    if (row % kCheckEvery == kCheckEvery - 1 && cancelled && cancelled()) {
      return absl::CancelledError("the stream was cancelled");
    }
    if (has_newest_ && number <= newest_) {
      ++late_frames_;
      continue;
    }
    if (has_newest_) PassGap(number);
    has_newest_ = true;
    newest_ = number;
    stream_.Push(positions_m.row(row));
    ProcessReady();
    if (is_fresh_) newest_in_states_ = number;
    is_fresh_ = false;
  }
  return absl::OkStatus();
}

absl::Status Observer::Check(std::int64_t first_frame, const FrameMatrix& positions_m) const {
  if (positions_m.cols() != stream_.source_width()) {
    return InvalidArgument("frame {}: expected {} numbers, three for each marker, got {}",
                           first_frame, stream_.source_width(), positions_m.cols());
  }
  if (first_frame > std::numeric_limits<std::int64_t>::max() - (positions_m.rows() - 1)) {
    return InvalidArgument("frame {}: expected a number below the maximum for {} frames",
                           first_frame, positions_m.rows());
  }
  for (Eigen::Index row = 0; row < positions_m.rows(); ++row) {
    for (const float x : positions_m.row(row)) {
      if (std::abs(x) > kMaxPosition_m) {
        return InvalidArgument("frame {}: expected positions up to {} m, got {}", first_frame + row,
                               kMaxPosition_m, x);
      }
    }
  }
  return absl::OkStatus();
}

void Observer::PassGap(std::int64_t number) {
  // Unsigned, because numbers may differ by more than the int64 range.
  const std::uint64_t skipped =
      static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(newest_) - 1;
  if (skipped == 0) return;
  const auto countable =
      static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max() - missing_frames_);
  missing_frames_ += static_cast<std::int64_t>(std::min(skipped, countable));
  if (static_cast<double>(skipped) > options_.window_seconds * frame_rate_hz_) {
    RestartStream();
    return;
  }
  for (std::uint64_t i = 0; i < skipped; ++i) {
    stream_.PushMissing();
    ProcessReady();
  }
}

void Observer::RestartStream() {
  stream_.Restart();
  Forget();
}

void Observer::Forget() {
  states_.Restart();
  filter_->Restart();
  recognizer_->Restart();
}

void Observer::ProcessReady() {
  while (const Eigen::RowVectorXf* frame = stream_.Next()) {
    Process(*frame);
    if (is_measuring_) MeasureLeg();
    is_fresh_ = true;
  }
}

const float* Observer::Scaled(std::int64_t frame) {
  scaled_ = states_.state(frame);
  model_->scale().Apply(scaled_);
  return scaled_.data();
}

void Observer::Process(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m) {
  if (!states_.Push(positions_m) || !has_leg_length_) return;
  // The previous frame is finished now.
  if (states_.next() > 1) filter_->Advance(Scaled(states_.next() - 2));
}

void Observer::ReprocessKept() {
  const FrameMatrix kept = states_.LastPositions(states_.kept()).positions_m;
  Forget();
  for (Eigen::Index t = 0; t < kept.rows(); ++t) Process(kept.row(t));
}

void Observer::MeasureLeg() {
  const int kept = states_.kept();
  if (kept == 0) return;
  const auto measured = EstimateLegLength(set_, states_.LastPositions(kept));
  if (!measured.ok() || !IsLegLength(*measured)) return;
  is_measuring_ = kept < InFrames(kMinKeptSeconds, model_->settings().frame_rate_hz);
  const double change = std::abs(*measured / states_.leg_length_m() - 1);
  if (has_leg_length_ && change <= (is_measuring_ ? kMinLegChange : 0)) return;
  has_leg_length_ = true;
  states_.set_leg_length_m(*measured);
  ReprocessKept();
}

absl::StatusOr<std::optional<Observed>> Observer::Answer(const Cancelled& cancelled) {
  if (states_.kept() == 0 || !has_leg_length_) return std::nullopt;
  Observed observed;
  observed.frame = newest_in_states_;
  observed.layer = filter_->layer();
  observed.state = filter_->Peek(Scaled(states_.next() - 1));
  MOTIONDB_ASSIGN_OR_RETURN(auto recognized, recognizer_->Recognize(states_, cancelled));
  observed.labels = std::move(recognized.labels);
  observed.unknown_probability = recognized.unknown_probability;
  observed.familiarity = recognized.familiarity;
  observed.other_tracks = std::move(recognized.other_tracks);
  if (!options_.horizon_seconds.empty()) {
    MOTIONDB_RETURN_IF_ERROR(PredictInto(cancelled, observed));
  }
  return observed;
}

absl::Status Observer::PredictInto(const Cancelled& cancelled, Observed& observed) const {
  PredictOptions options;
  options.history_seconds = options_.history_seconds;
  options.horizon_seconds = options_.horizon_seconds;
  options.transition_floor = options_.transition_floor;
  options.layer = filter_->layer();
  options.mask = mask_;
  const int history = std::min(
      states_.kept(), InFrames(options_.history_seconds, model_->settings().frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(observed.horizons,
                            PredictFrames(*model_, states_.Last(history), options, cancelled));
  return absl::OkStatus();
}

}  // namespace motiondb::core
