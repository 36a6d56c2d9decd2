// A model <-> bytes, all but its states and root path, which are those of its clips and are stored
// with them; storage/README.md gives the layout. Encoding what was decoded gives the same bytes.
// Decoding gives DATA_LOSS for any bytes that are not a model's, and takes no memory that they do
// not account for. Safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

absl::Status EncodeModel(const core::ModelParts& parts, ByteSink& sink);

// `states` and `root_path` are left empty. The clips follow each other and hold as many frames as
// the tree; whether all else fits is for core::Model::Create to say.
absl::StatusOr<core::ModelParts> DecodeModel(ByteSource& source);

}  // namespace motiondb::storage
