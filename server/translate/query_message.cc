#include "server/translate/query_message.h"

#include <algorithm>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/message_fields.h"
#include "server/translate/observation_message.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

namespace {

absl::Status CheckCount(std::string_view field, int count) {
  if (count >= 1) return absl::OkStatus();
  return FieldViolation(field, "expected 1 or more, got {}", count);
}

std::size_t Count(std::size_t all, int top_count) {
  return top_count == 0 ? all : std::min(all, static_cast<std::size_t>(top_count));
}

}  // namespace

void SetState(const core::NodeState& state, v1::NodeState& message) {
  message.set_node_id(state.node);
  message.set_probability(state.probability);
}

void SetLabels(const std::vector<core::LabelScore>& labels, int top_count,
               google::protobuf::RepeatedPtrField<v1::LabelProbability>& messages) {
  for (std::size_t i = 0; i < Count(labels.size(), top_count); ++i) {
    v1::LabelProbability& to = *messages.Add();
    to.set_label(labels[i].label);
    to.set_probability(labels[i].probability);
  }
}

void SetTracks(const std::vector<core::TrackAnswer>& tracks, int top_count,
               google::protobuf::RepeatedPtrField<v1::TrackLabels>& messages) {
  for (const core::TrackAnswer& track : tracks) {
    v1::TrackLabels& to = *messages.Add();
    to.set_track(track.track);
    SetLabels(track.labels, top_count, *to.mutable_labels());
  }
}

void SetHorizons(const std::vector<core::PredictedFrame>& frames,
                 google::protobuf::RepeatedPtrField<v1::PredictedFrame>& messages) {
  for (const core::PredictedFrame& frame : frames) {
    v1::PredictedFrame& to = *messages.Add();
    to.set_seconds(frame.seconds);
    const auto& positions = frame.marker_positions_m;
    AppendPacked(positions.data(), static_cast<std::size_t>(positions.size()),
                 *to.mutable_marker_positions());
    to.set_marker_count(static_cast<int>(positions.size() / 3));
    if (frame.confidence) to.set_confidence(*frame.confidence);
    if (frame.expected_error_m) to.set_expected_error_m(*frame.expected_error_m);
    to.set_extrapolated(frame.extrapolated);
  }
}

void SetRecognition(const std::vector<core::RecognizedWindow>& windows, const std::string& database,
                    const core::Model& model, int top_count, v1::RecognizeResponse& message) {
  for (const core::RecognizedWindow& window : windows) {
    v1::RecognitionWindow& to = *message.add_windows();
    to.set_start_seconds(window.start_seconds);
    to.set_end_seconds(window.end_seconds);
    to.set_layer(window.layer);
    if (window.unknown_probability) to.set_unknown_probability(*window.unknown_probability);
    to.set_familiarity(window.familiarity);
    for (std::size_t i = 0; i < Count(window.clips.size(), top_count); ++i) {
      const core::ModelClip& clip = model.clips()[window.clips[i].clip];
      v1::ClipProbability& ranked = *to.add_clips();
      ranked.set_clip(ClipName(database, clip.id));
      ranked.set_label(window.clips[i].label);
      ranked.set_log_probability(window.clips[i].log_probability);
    }
    SetLabels(window.labels, 0, *to.mutable_labels());
    SetTracks(window.other_tracks, 0, *to.mutable_other_tracks());
  }
}

void SetMatches(const std::vector<core::MotionMatch>& matches, const std::string& database,
                const core::Model& model, v1::FindResponse& message) {
  const double rate = model.settings().frame_rate_hz;
  for (const core::MotionMatch& match : matches) {
    v1::FindMatch& to = *message.add_matches();
    to.set_clip(ClipName(database, model.clips()[match.clip].id));
    to.set_start_seconds(match.first_frame / rate);
    to.set_end_seconds((match.first_frame + match.frame_count) / rate);
    to.set_score(match.score);
  }
}

void SetEstimation(const core::Estimation& estimation, const core::Model& model,
                   v1::EstimateResponse& message) {
  message.set_layer(estimation.layer);
  for (const core::NodePath& path : estimation.paths) {
    v1::NodePath& to = *message.add_paths();
    to.mutable_node_ids()->Add(path.nodes.begin(), path.nodes.end());
    to.set_log_probability(path.log_probability);
  }
  SetState(estimation.state, *message.mutable_state());
  const double rate = model.settings().frame_rate_hz;
  message.set_frame_rate_hz(rate);
  for (const core::FilledFrame& filled : estimation.filled) {
    v1::FilledFrame& to = *message.add_filled_frames();
    to.set_frame(filled.frame);
    to.set_seconds(filled.frame / rate);
    const auto& positions = filled.marker_positions_m;
    AppendPacked(positions.data(), static_cast<std::size_t>(positions.size()),
                 *to.mutable_marker_positions());
    const auto& deviations = filled.deviations_m;
    AppendPacked(deviations.data(), static_cast<std::size_t>(deviations.size()),
                 *to.mutable_marker_deviations());
    to.set_marker_count(static_cast<int>(deviations.size()));
  }
}

void SetPrediction(const core::Prediction& prediction, const std::string& database,
                   const core::Model& model, v1::PredictResponse& message) {
  message.set_at_seconds(prediction.at_seconds);
  message.set_layer(prediction.layer);
  SetState(prediction.state, *message.mutable_state());
  for (const core::NextNode& next : prediction.next_nodes) {
    v1::NextNode& to = *message.add_next_nodes();
    to.set_node_id(next.node);
    to.set_probability(next.probability);
    for (const int clip : next.clips) to.add_clips(ClipName(database, model.clips()[clip].id));
  }
  SetHorizons(prediction.horizons, *message.mutable_horizons());
  if (prediction.unknown_probability) {
    message.set_unknown_probability(*prediction.unknown_probability);
  }
}

namespace {

// Checks the number of clips or labels to return of each window, if the request has one.
template <typename Request>
absl::Status CheckTopCount(const Request& request) {
  return request.has_top_count() ? CheckCount("top_count", request.top_count()) : absl::OkStatus();
}

// The layer of a request; 0, core's word for the bottom layer, if it has none.
template <typename Request>
absl::StatusOr<int> LayerFrom(const Request& request) {
  if (!request.has_layer()) return 0;
  MOTIONDB_RETURN_IF_ERROR(CheckCount("layer", request.layer()));
  return request.layer();
}

absl::StatusOr<core::Method> MethodFrom(v1::Method method) {
  switch (method) {
    case v1::METHOD_UNSPECIFIED:
    case v1::METHOD_BEST:
      return core::Method::kBest;
    case v1::METHOD_PAPER:
      return core::Method::kPaper;
    default:
      return FieldViolation("method", "unknown method {}; expected best or paper",
                            static_cast<int>(method));
  }
}

// The part of a motion from the start_seconds to the end_seconds of a message.
template <typename Message>
core::TimeRange PartOf(const Message& message) {
  core::TimeRange part;
  if (message.has_start_seconds()) part.start_seconds = message.start_seconds();
  if (message.has_end_seconds()) part.end_seconds = message.end_seconds();
  return part;
}

absl::StatusOr<core::Generation> GenerationFrom(v1::Generation generation) {
  switch (generation) {
    case v1::GENERATION_UNSPECIFIED:
    case v1::GENERATION_EXACT:
      return core::Generation::kExact;
    case v1::GENERATION_TOP_PATHS:
      return core::Generation::kTopPaths;
    default:
      return FieldViolation("generation", "unknown generation {}; expected exact or top paths",
                            static_cast<int>(generation));
  }
}

}  // namespace

absl::StatusOr<core::RecognizeOptions> ParseRecognizeOptions(const v1::RecognizeRequest& request) {
  core::RecognizeOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(options.method, MethodFrom(request.method()));
  MOTIONDB_ASSIGN_OR_RETURN(options.generation, GenerationFrom(request.generation()));
  MOTIONDB_RETURN_IF_ERROR(CheckTopCount(request));
  options.whole = request.whole();
  if (request.has_window_seconds()) options.window_seconds = request.window_seconds();
  if (request.has_hop_seconds()) options.hop_seconds = request.hop_seconds();
  MOTIONDB_ASSIGN_OR_RETURN(options.layer, LayerFrom(request));
  if (request.has_transition_floor()) options.transition_floor = request.transition_floor();
  if (request.has_path_count()) options.path_count = request.path_count();
  options.track = request.track();
  return options;
}

core::FindOptions ParseFindOptions(const v1::FindRequest& request) {
  core::FindOptions options;
  if (request.has_top_count()) options.top_count = request.top_count();
  options.exhaustive = request.exhaustive();
  return options;
}

absl::StatusOr<SoughtMotion> ParseSoughtMotion(const v1::FindRequest& request,
                                               const std::string& database) {
  SoughtMotion motion;
  if (request.motion_case() == v1::FindRequest::kClipRange) {
    const v1::ClipRange& range = request.clip_range();
    for (const auto& [field, is_set] : {std::pair("start_seconds", request.has_start_seconds()),
                                        std::pair("end_seconds", request.has_end_seconds())}) {
      if (is_set) return FieldViolation(field, "expected none with clip_range, which has its own");
    }
    MOTIONDB_ASSIGN_OR_RETURN(motion.source, IdIn(database, "clip_range.clip", "clip", range.clip(),
                                                  ParseClipName("clip_range.clip", range.clip())));
    motion.part = PartOf(range);
    return motion;
  }
  MOTIONDB_ASSIGN_OR_RETURN(motion.source,
                            ParseObservation("observation", request.observation(), database));
  motion.part = PartOf(request);
  return motion;
}

absl::StatusOr<core::EstimateOptions> ParseEstimateOptions(const v1::EstimateRequest& request) {
  core::EstimateOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(options.search.layer, LayerFrom(request));
  if (request.has_path_count()) options.search.path_count = request.path_count();
  if (request.has_transition_floor()) options.search.transition_floor = request.transition_floor();
  if (request.has_max_candidates()) options.search.max_candidates = request.max_candidates();
  if (request.fill_every_frame()) options.fill = core::Fill::kEveryFrame;
  return options;
}

absl::StatusOr<core::PredictOptions> ParsePredictOptions(const v1::PredictRequest& request) {
  core::PredictOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(options.method, MethodFrom(request.method()));
  if (request.has_at_seconds()) options.at_seconds = request.at_seconds();
  if (request.has_history_seconds()) options.history_seconds = request.history_seconds();
  if (!request.horizon_seconds().empty()) {
    options.horizon_seconds = {request.horizon_seconds().begin(), request.horizon_seconds().end()};
  }
  MOTIONDB_ASSIGN_OR_RETURN(options.layer, LayerFrom(request));
  if (request.has_transition_floor()) options.transition_floor = request.transition_floor();
  return options;
}

absl::StatusOr<SeriesOptions> ParseSeriesOptions(const v1::PredictSeriesRequest& request) {
  auto prediction = ParsePredictOptions(request.prediction());
  if (!prediction.ok()) return core::Within("prediction", prediction.status());
  return SeriesOptions{*std::move(prediction), request.every_seconds()};
}

absl::StatusOr<core::ObserverOptions> ParseObserverOptions(const v1::ObserveStart& start) {
  core::ObserverOptions options;
  if (start.has_window_seconds()) options.window_seconds = start.window_seconds();
  if (start.has_history_seconds()) options.history_seconds = start.history_seconds();
  options.horizon_seconds = {start.horizon_seconds().begin(), start.horizon_seconds().end()};
  MOTIONDB_ASSIGN_OR_RETURN(options.layer, LayerFrom(start));
  if (start.has_transition_floor()) options.transition_floor = start.transition_floor();
  MOTIONDB_RETURN_IF_ERROR(CheckTopCount(start));
  options.track = start.track();
  return options;
}

}  // namespace motiondb::server
