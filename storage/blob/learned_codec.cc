#include <cmath>
#include <utility>

#include "storage/blob/byte_stream.h"
#include "storage/blob/model_codec.h"

namespace motiondb::storage {

namespace {

constexpr std::size_t kErrorModelBytes = 12 * sizeof(double);

}  // namespace

void PutPrior(FieldWriter& writer, const core::MotionPrior& prior) {
  writer.PutArray(prior.seconds);
  PutMatrix(writer, prior.weights);
}

core::MotionPrior GetPrior(FieldReader& reader, Eigen::Index dimensions) {
  core::MotionPrior prior;
  prior.seconds = reader.GetArray<double>();
  for (std::size_t i = 0; i < prior.seconds.size(); ++i) {
    if (!(prior.seconds[i] > (i == 0 ? 0 : prior.seconds[i - 1]))) {
      reader.Fail(core::DataLoss("motion prior: its horizons are not in ascending order"));
      return {};
    }
  }
  const auto horizons = static_cast<Eigen::Index>(prior.seconds.size());
  const Eigen::Index numbers = dimensions / 2;
  GetMatrix(reader, horizons == 0 ? 0 : (1 + core::kLags) * numbers, horizons * numbers,
            prior.weights);
  return prior;
}

void PutConfidence(FieldWriter& writer, const core::PredictionConfidence& confidence) {
  writer.PutCount(confidence.models.size());
  for (const core::ErrorModel& model : confidence.models) {
    writer.Put(model.seconds);
    for (const double coefficient : model.coefficients) writer.Put(coefficient);
    for (const double lowest : model.lowest) writer.Put(lowest);
    for (const double highest : model.highest) writer.Put(highest);
    writer.Put(model.deviation);
  }
}

core::PredictionConfidence GetConfidence(FieldReader& reader) {
  core::PredictionConfidence confidence;
  confidence.models.resize(reader.GetCount(kErrorModelBytes));
  double before = 0;
  for (core::ErrorModel& model : confidence.models) {
    model.seconds = reader.Get<double>();
    bool finite = model.seconds > before && std::isfinite(model.seconds);
    before = model.seconds;
    const auto get = [&](auto& numbers) {
      for (double& number : numbers) {
        number = reader.Get<double>();
        finite = finite && std::isfinite(number);
      }
    };
    get(model.coefficients);
    get(model.lowest);
    get(model.highest);
    model.deviation = reader.Get<double>();
    for (std::size_t i = 0; i < model.lowest.size(); ++i) {
      finite = finite && model.lowest[i] <= model.highest[i];
    }
    if (!finite || !(model.deviation > 0)) {
      reader.Fail(core::DataLoss("confidence: invalid error model of the predictions"));
      return {};
    }
  }
  return confidence;
}

namespace {

void PutAnswer(FieldWriter& writer, const core::AnswerCalibration& calibration) {
  writer.Put(calibration.weight.scale);
  writer.Put(calibration.weight.power);
  writer.PutArray(calibration.familiarity);
}

core::AnswerCalibration GetAnswer(FieldReader& reader) {
  core::AnswerCalibration calibration;
  calibration.weight.scale = reader.Get<double>();
  calibration.weight.power = reader.Get<double>();
  calibration.familiarity = reader.GetArray<float>();
  const auto& [scale, power] = calibration.weight;
  if (!(scale > 0 && std::isfinite(scale) && power >= 0 && power <= 1)) {
    reader.Fail(
        core::DataLoss("calibration: invalid evidence weight: scale {}, power {}", scale, power));
  }
  for (std::size_t i = 0; i < calibration.familiarity.size(); ++i) {
    const float score = calibration.familiarity[i];
    if (std::isnan(score) || (i > 0 && score < calibration.familiarity[i - 1])) {
      reader.Fail(core::DataLoss("calibration: its familiarity scores are not in ascending order"));
      break;
    }
  }
  return calibration;
}

}  // namespace

void PutMetric(FieldWriter& writer, const core::MotionMetric& metric) {
  writer.PutCount(static_cast<std::size_t>(metric.projection.cols()));
  if (metric.empty()) return;
  writer.PutCount(static_cast<std::size_t>(metric.loadings.cols()));
  PutMatrix(writer, metric.mean);
  PutMatrix(writer, metric.loadings);
  writer.Put(metric.noise);
  PutMatrix(writer, metric.whitening);
  PutMatrix(writer, metric.projection);
}

core::MotionMetric GetMetric(FieldReader& reader, Eigen::Index dimensions) {
  core::MotionMetric metric;
  const auto directions = reader.Get<std::uint32_t>();
  if (directions == 0) return metric;
  if (dimensions == 0) {
    reader.Fail(core::DataLoss("metric: {} directions in a space of 0 dimensions", directions));
    return metric;
  }
  const auto loadings = reader.Get<std::uint32_t>();
  GetMatrix(reader, 1, dimensions, metric.mean);
  GetMatrix(reader, dimensions, loadings, metric.loadings);
  metric.noise = reader.Get<double>();
  GetMatrix(reader, dimensions, dimensions, metric.whitening);
  GetMatrix(reader, dimensions, directions, metric.projection);
  return metric;
}

namespace {

void PutUnknown(FieldWriter& writer, const core::UnknownModel& model) {
  writer.Put(model.intercept);
  for (const double weight : model.weights) writer.Put(weight);
  writer.Put(model.typical_log_distance);
  writer.PutCount(model.labels.size());
  for (const core::LabelDistance& of_label : model.labels) {
    writer.PutText(of_label.label);
    writer.Put(of_label.log_distance);
  }
}

core::UnknownModel GetUnknown(FieldReader& reader) {
  constexpr std::size_t kMinLabelBytes = sizeof(double) + sizeof(std::uint32_t);
  core::UnknownModel model;
  model.intercept = reader.Get<double>();
  for (double& weight : model.weights) weight = reader.Get<double>();
  model.typical_log_distance = reader.Get<double>();
  bool valid = std::isfinite(model.intercept) && std::isfinite(model.typical_log_distance);
  for (const double weight : model.weights) valid = valid && std::isfinite(weight);
  model.labels.resize(reader.GetCount(kMinLabelBytes));
  for (std::size_t i = 0; i < model.labels.size(); ++i) {
    core::LabelDistance& of_label = model.labels[i];
    of_label.label = reader.GetText();
    of_label.log_distance = reader.Get<double>();
    valid = valid && std::isfinite(of_label.log_distance) &&
            (i == 0 || model.labels[i - 1].label < of_label.label);
  }
  if (!valid) reader.Fail(core::DataLoss("calibration: invalid model of unknown motion"));
  return model;
}

// Reads over a model of versions 4 and 5, which had other features: intercept, three weights, and
// mean and deviation of a typical label and of each label.
void SkipEarlierUnknown(FieldReader& reader) {
  constexpr std::size_t kMinLabelBytes = 2 * sizeof(double) + sizeof(std::uint32_t);
  for (int i = 0; i < 6; ++i) reader.Get<double>();
  const std::size_t labels = reader.GetCount(kMinLabelBytes);
  for (std::size_t i = 0; i < labels && reader.ok(); ++i) {
    reader.GetText();
    reader.Get<double>();
    reader.Get<double>();
  }
}

}  // namespace

void PutRecognition(FieldWriter& writer, const core::RecognitionCalibration& calibration) {
  PutAnswer(writer, calibration.window);
  PutAnswer(writer, calibration.whole);
  writer.Put(static_cast<std::uint32_t>(calibration.unknown));
  if (calibration.unknown != core::UnknownCalibration::kFitted) return;
  PutUnknown(writer, *calibration.window.unknown);
  PutUnknown(writer, *calibration.whole.unknown);
}

core::RecognitionCalibration GetRecognition(FieldReader& reader, StoredUnknown stored) {
  core::RecognitionCalibration calibration;
  calibration.window = GetAnswer(reader);
  calibration.whole = GetAnswer(reader);
  if (stored == StoredUnknown::kNone) return calibration;
  const auto unknown = reader.Get<std::uint32_t>();
  if (unknown > static_cast<std::uint32_t>(core::UnknownCalibration::kTooFewClips)) {
    reader.Fail(core::DataLoss("calibration: unknown kind {}", unknown));
    return calibration;
  }
  calibration.unknown = static_cast<core::UnknownCalibration>(unknown);
  if (!reader.ok() || calibration.unknown != core::UnknownCalibration::kFitted) return calibration;
  if (stored == StoredUnknown::kEarlier) {
    SkipEarlierUnknown(reader);
    SkipEarlierUnknown(reader);
    calibration.unknown = core::UnknownCalibration::kNotFitted;
    return calibration;
  }
  calibration.window.unknown = GetUnknown(reader);
  calibration.whole.unknown = GetUnknown(reader);
  return calibration;
}

namespace {

using core::Edge;

static_assert(sizeof(Edge) == 8, "edges are stored in their memory layout");

bool RowsFit(const std::vector<std::int32_t>& row_begin, std::size_t edge_count) {
  if (row_begin.empty() || row_begin.front() != 0) return false;
  for (std::size_t k = 1; k < row_begin.size(); ++k) {
    if (row_begin[k] < row_begin[k - 1]) return false;
  }
  return static_cast<std::size_t>(row_begin.back()) == edge_count;
}

// Returns whether the edges of each row ascend and lead to existing nodes.
bool EdgesFit(const std::vector<std::int32_t>& row_begin, const std::vector<Edge>& edges) {
  const auto node_count = static_cast<std::int32_t>(row_begin.size()) - 1;
  for (std::int32_t k = 0; k < node_count; ++k) {
    std::int32_t before = -1;
    for (std::int32_t e = row_begin[k]; e < row_begin[k + 1]; ++e) {
      if (edges[e].to <= before || edges[e].to >= node_count || edges[e].count <= 0) return false;
      before = edges[e].to;
    }
  }
  return true;
}

}  // namespace

void PutGraph(FieldWriter& writer, const core::TransitionGraph& graph) {
  writer.PutArray(graph.row_begin());
  writer.PutArray(graph.edges());
}

core::TransitionGraph GetGraph(FieldReader& reader) {
  auto row_begin = reader.GetArray<std::int32_t>();
  auto edges = reader.GetArray<Edge>();
  if (!reader.ok()) return {};
  if (!RowsFit(row_begin, edges.size()) || !EdgesFit(row_begin, edges)) {
    reader.Fail(
        core::DataLoss("transition graph: its edges are invalid or not in ascending order"));
    return {};
  }
  return core::TransitionGraph(std::move(row_begin), std::move(edges));
}

void PutClipGraph(FieldWriter& writer, const core::ClipGraph& graph) {
  writer.PutArray(graph.nodes);
  writer.PutArray(graph.frames);
  PutGraph(writer, graph.transitions);
}

core::ClipGraph GetClipGraph(FieldReader& reader) {
  core::ClipGraph graph;
  graph.nodes = reader.GetArray<std::int32_t>();
  graph.frames = reader.GetArray<std::int32_t>();
  graph.transitions = GetGraph(reader);
  return graph;
}

}  // namespace motiondb::storage
