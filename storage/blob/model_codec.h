// Binary format of a model without its states and root path, which are stored with the clips;
// docs/storage_format.md describes the layout. Encoding a decoded model returns the same bytes.
// Decoding returns DATA_LOSS for invalid bytes and never allocates more memory than their size
// justifies.
#pragma once

#include "absl/status/statusor.h"
#include "core/graph/transition_graph.h"
#include "core/model/answer_calibration.h"
#include "core/model/model.h"
#include "core/model/motion_metric.h"
#include "core/model/motion_prior.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

// REQUIRES: the labels are resolved, as in the parts of a core::Model.
absl::Status EncodeModel(const core::ModelParts& parts, ByteSink& sink);

// Leaves `states` and `root_path` empty. Checks that the clips are contiguous and that their frames
// are those of the tree; core::Model::Create checks the rest. NewerFormat: of a newer version.
absl::StatusOr<core::ModelParts> DecodeModel(ByteSource& source);

// Transition graphs as fields of a model. Reading checks every invariant of transition_graph.h; if
// one is violated, `reader` fails with DATA_LOSS.

// Minimum size of an encoded graph and of an encoded clip graph.
inline constexpr std::size_t kGraphBytes = 3 * sizeof(std::uint32_t);
inline constexpr std::size_t kClipGraphBytes = 2 * sizeof(std::uint32_t) + kGraphBytes;

void PutGraph(FieldWriter& writer, const core::TransitionGraph& graph);
core::TransitionGraph GetGraph(FieldReader& reader);

void PutClipGraph(FieldWriter& writer, const core::ClipGraph& graph);
core::ClipGraph GetClipGraph(FieldReader& reader);

// The learned parts of a model as fields: prediction (prior, confidence) and recognition (metric,
// calibration). `dimensions`: numbers in a state. Corruption makes `reader` fail with DATA_LOSS.

void PutPrior(FieldWriter& writer, const core::MotionPrior& prior);
core::MotionPrior GetPrior(FieldReader& reader, Eigen::Index dimensions);

void PutConfidence(FieldWriter& writer, const core::PredictionConfidence& confidence);
core::PredictionConfidence GetConfidence(FieldReader& reader);

void PutMetric(FieldWriter& writer, const core::MotionMetric& metric);
core::MotionMetric GetMetric(FieldReader& reader, Eigen::Index dimensions);

void PutRecognition(FieldWriter& writer, const core::RecognitionCalibration& calibration);

// The UnknownModel of a stored calibration. An earlier kind, with other features, is not used: the
// calibration is kNotFitted.
enum class StoredUnknown { kNone, kEarlier, kCurrent };

core::RecognitionCalibration GetRecognition(FieldReader& reader, StoredUnknown stored);

}  // namespace motiondb::storage
