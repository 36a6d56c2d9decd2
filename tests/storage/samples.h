// Small records, clips, skeletons and models that tests of stores are made of. The same arguments
// give the same values.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/model/model.h"
#include "storage/records.h"

namespace motiondb::tests {

// A name that no sample has.
inline constexpr char kUnknown[] = "no-such-thing";

storage::DatabaseRecord SampleDatabase(const std::string& name);

// The set that the states below are of: three markers, 18 dimensions.
core::MarkerSet SampleMarkerSet();

// A random walk; other seeds walk elsewhere. NaN nowhere.
core::StateSequence SampleStates(int frames, unsigned seed);

core::Skeleton SampleSkeleton(const std::string& name, double thigh_m = 0.4);

// A clip of 60 frames with a skeleton. Its content is told by `seed`.
storage::NewClip SampleClip(const std::string& database, const std::string& id, unsigned seed);

// A model of these clips, in the order given, under the sample database's settings.
core::Model SampleModel(const std::vector<storage::NewClip>& clips);

storage::OperationRecord SampleOperation(const std::string& database, const std::string& id);

// Whether all fields are the same.
bool Same(const storage::DatabaseRecord& a, const storage::DatabaseRecord& b);
bool Same(const storage::ClipRecord& a, const storage::ClipRecord& b);
bool Same(const storage::ModelRecord& a, const storage::ModelRecord& b);
bool Same(const storage::OperationRecord& a, const storage::OperationRecord& b);
// Whether they are the same bit for bit, NaN included.
bool Same(const core::StateSequence& a, const core::StateSequence& b);
bool Same(const core::Skeleton& a, const core::Skeleton& b);
bool Same(const core::Model& a, const core::Model& b);

// Encoded as the store has them.
std::string Encoded(const core::StateSequence& states);
std::string Encoded(const core::Skeleton& skeleton);
std::string Encoded(const core::ModelParts& parts);

}  // namespace motiondb::tests
