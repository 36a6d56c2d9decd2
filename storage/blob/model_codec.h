// A model <-> bytes, all but its states and root path, which are those of its clips and are stored
// with them; docs/storage_format.md gives the layout. Encoding what was decoded gives the same
// bytes. Decoding gives DATA_LOSS for any bytes that are not a model's, and takes no memory that
// they do not account for. Safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/graph/transition_graph.h"
#include "core/model/model.h"
#include "core/model/motion_metric.h"
#include "core/model/motion_prior.h"
#include "core/model/prediction_confidence.h"
#include "core/model/recognition_calibration.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

absl::Status EncodeModel(const core::ModelParts& parts, ByteSink& sink);

// `states` and `root_path` are left empty. The clips follow each other and hold as many frames as
// the tree; whether all else fits is for core::Model::Create to say.
absl::StatusOr<core::ModelParts> DecodeModel(ByteSource& source);

// Transition graphs <-> fields of a model's bytes; docs/storage_format.md gives the layout. The
// readers keep every promise of transition_graph.h or make the reader fail. Safe to call from any
// thread.

// Fewest bytes that a graph and a clip's graph take.
inline constexpr std::size_t kGraphBytes = 3 * sizeof(std::uint32_t);
inline constexpr std::size_t kClipGraphBytes = 2 * sizeof(std::uint32_t) + kGraphBytes;

void PutGraph(FieldWriter& writer, const core::TransitionGraph& graph);
core::TransitionGraph GetGraph(FieldReader& reader);

void PutClipGraph(FieldWriter& writer, const core::ClipGraph& graph);
core::ClipGraph GetClipGraph(FieldReader& reader);

// What a model has learned <-> fields of its bytes: of how motion goes on, and of recognition (the
// metric and the calibration). `dimensions`: of a state. Damage is DATA_LOSS in the reader.

void PutPrior(FieldWriter& writer, const core::MotionPrior& prior);
// `dimensions`: of a state.
core::MotionPrior GetPrior(FieldReader& reader, Eigen::Index dimensions);

void PutConfidence(FieldWriter& writer, const core::PredictionConfidence& confidence);
core::PredictionConfidence GetConfidence(FieldReader& reader);

void PutMetric(FieldWriter& writer, const core::MotionMetric& metric);
// Of states of `dimensions` numbers.
core::MotionMetric GetMetric(FieldReader& reader, Eigen::Index dimensions);

void PutRecognition(FieldWriter& writer, const core::RecognitionCalibration& calibration);
core::RecognitionCalibration GetRecognition(FieldReader& reader);

}  // namespace motiondb::storage
