#include "server/translate/query_options.h"

#include <limits>

#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/field_violation.h"
#include "server/translate/numbers.h"

namespace motiondb::server {
namespace {

constexpr double kRounding = 1e-3;  // 0.0167 s is a frame at 60 Hz to who writes it
constexpr int kMostPaths = 100;
constexpr int kMostHorizons = 1000;
constexpr int kMostOfAnything = std::numeric_limits<int>::max();

absl::StatusOr<int> LayerFrom(const std::string& field, int layer, const core::Model& model) {
  MOTIONDB_RETURN_IF_ERROR(IntegerBetween(field, layer, 0, kMostOfAnything).status());
  auto resolved = model.ResolveLayer(layer);
  if (!resolved.ok()) return AtField(field, resolved.status());
  return resolved;
}

// `fallback` where the message leaves the floor out.
template <typename Message>
absl::StatusOr<double> FloorFrom(const std::string& field, const Message& message,
                                 double fallback) {
  if (!message.has_transition_floor()) return fallback;
  return Probability(field, message.transition_floor());
}

// None where the message has none.
absl::StatusOr<std::vector<double>> HorizonsFrom(
    const std::string& field, const google::protobuf::RepeatedField<double>& seconds) {
  if (seconds.size() > kMostHorizons) {
    return FieldViolation(field, "expected at most {}, got {}", kMostHorizons, seconds.size());
  }
  std::vector<double> horizons;
  for (const double horizon : seconds) {
    MOTIONDB_ASSIGN_OR_RETURN(const double checked, NotNegative(field, horizon));
    horizons.push_back(checked);
  }
  return horizons;
}

absl::StatusOr<core::Method> MethodFrom(const std::string& field, v1::Method method) {
  switch (method) {
    case v1::METHOD_UNSPECIFIED:
    case v1::BEST:
      return core::Method::kBest;
    case v1::PAPER:
      return core::Method::kPaper;
    default:
      return FieldViolation(field, "{} is no method", static_cast<int>(method));
  }
}

absl::StatusOr<core::Generation> GenerationFrom(v1::Generation generation) {
  switch (generation) {
    case v1::GENERATION_UNSPECIFIED:
    case v1::GENERATION_EXACT:
      return core::Generation::kExact;
    case v1::GENERATION_TOP_PATHS:
      return core::Generation::kTopPaths;
    default:
      return FieldViolation("generation", "{} is no way to sum", static_cast<int>(generation));
  }
}

}  // namespace

absl::StatusOr<double> StepFrom(std::string_view field, double seconds, const core::Model& model) {
  MOTIONDB_ASSIGN_OR_RETURN(const double step, Positive(field, seconds));
  const double frame = 1 / model.settings().frame_rate_hz;
  if (step >= frame * (1 - kRounding)) return step;
  return FieldViolation(field, "expected at least a frame of the database, {:.6f} s, got {}", frame,
                        step);
}

absl::StatusOr<core::RecognizeOptions> OptionsFrom(const v1::RecognizeRequest& request,
                                                   const core::Model& model) {
  core::RecognizeOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(options.method, MethodFrom("method", request.method()));
  options.whole = request.whole();
  MOTIONDB_ASSIGN_OR_RETURN(
      options.window_seconds,
      PositiveOr("window_seconds", request.window_seconds(), options.window_seconds));
  MOTIONDB_ASSIGN_OR_RETURN(options.hop_seconds,
                            PositiveOr("hop_seconds", request.hop_seconds(), options.hop_seconds));
  MOTIONDB_ASSIGN_OR_RETURN(options.layer, LayerFrom("layer", request.layer(), model));
  MOTIONDB_RETURN_IF_ERROR(
      IntegerBetween("top_count", request.top_count(), 0, kMostOfAnything).status());
  MOTIONDB_ASSIGN_OR_RETURN(options.transition_floor,
                            FloorFrom("transition_floor", request, options.transition_floor));
  MOTIONDB_ASSIGN_OR_RETURN(options.generation, GenerationFrom(request.generation()));
  MOTIONDB_ASSIGN_OR_RETURN(const int paths,
                            IntegerBetween("path_count", request.path_count(), 0, kMostPaths));
  if (paths > 0) options.path_count = paths;
  return options;
}

absl::StatusOr<core::EstimateOptions> OptionsFrom(const v1::EstimateRequest& request,
                                                  const core::Model& model) {
  core::EstimateOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(options.search.layer, LayerFrom("layer", request.layer(), model));
  MOTIONDB_ASSIGN_OR_RETURN(const int paths,
                            IntegerBetween("path_count", request.path_count(), 0, kMostPaths));
  if (paths > 0) options.search.path_count = paths;
  MOTIONDB_ASSIGN_OR_RETURN(
      options.search.transition_floor,
      FloorFrom("transition_floor", request, options.search.transition_floor));
  if (request.has_max_candidates()) {
    MOTIONDB_ASSIGN_OR_RETURN(
        options.search.max_candidates,
        IntegerBetween("max_candidates", request.max_candidates(), 0, kMostOfAnything));
  }
  if (request.fill_every_frame()) options.fill = core::Fill::kEveryFrame;
  return options;
}

absl::StatusOr<core::PredictOptions> OptionsFrom(std::string_view prefix,
                                                 const v1::PredictRequest& request,
                                                 const core::Model& model) {
  const auto field = [&](std::string_view name) { return fmt::format("{}{}", prefix, name); };
  core::PredictOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(options.method, MethodFrom(field("method"), request.method()));
  if (request.has_at_seconds()) {
    MOTIONDB_ASSIGN_OR_RETURN(options.at_seconds,
                              NotNegative(field("at_seconds"), request.at_seconds()));
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      options.history_seconds,
      PositiveOr(field("history_seconds"), request.history_seconds(), options.history_seconds));
  if (!request.horizon_seconds().empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(options.horizon_seconds,
                              HorizonsFrom(field("horizon_seconds"), request.horizon_seconds()));
  }
  MOTIONDB_ASSIGN_OR_RETURN(options.layer, LayerFrom(field("layer"), request.layer(), model));
  MOTIONDB_ASSIGN_OR_RETURN(options.transition_floor, FloorFrom(field("transition_floor"), request,
                                                                options.transition_floor));
  return options;
}

absl::StatusOr<core::ObserverOptions> OptionsFrom(std::string_view prefix,
                                                  const v1::ObserveStart& start,
                                                  const core::Model& model) {
  const auto field = [&](std::string_view name) { return fmt::format("{}{}", prefix, name); };
  core::ObserverOptions options;
  MOTIONDB_ASSIGN_OR_RETURN(
      options.window_seconds,
      PositiveOr(field("window_seconds"), start.window_seconds(), options.window_seconds));
  MOTIONDB_ASSIGN_OR_RETURN(
      options.history_seconds,
      PositiveOr(field("history_seconds"), start.history_seconds(), options.history_seconds));
  MOTIONDB_ASSIGN_OR_RETURN(options.horizon_seconds,
                            HorizonsFrom(field("horizon_seconds"), start.horizon_seconds()));
  MOTIONDB_ASSIGN_OR_RETURN(options.layer, LayerFrom(field("layer"), start.layer(), model));
  MOTIONDB_ASSIGN_OR_RETURN(options.transition_floor,
                            FloorFrom(field("transition_floor"), start, options.transition_floor));
  MOTIONDB_RETURN_IF_ERROR(
      IntegerBetween(field("top_count"), start.top_count(), 0, kMostOfAnything).status());
  return options;
}

}  // namespace motiondb::server
