// Small records, clips, skeletons and models for tests of stores. The same arguments give the same
// values.
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

// The marker set of the sample states: three markers, 18 dimensions.
core::MarkerSet SampleMarkerSet();

// Returns a random walk without NaN, chosen by `seed`.
core::StateSequence SampleStates(int frames, unsigned seed);

core::Skeleton SampleSkeleton(const std::string& name, double thigh_m = 0.4);

// Returns a clip of 60 frames with a skeleton. `seed` determines its content.
storage::NewClip SampleClip(const std::string& database, const std::string& id, unsigned seed);

// Builds a model of `clips`, in this order, with the settings of the sample database.
core::Model SampleModel(const std::vector<storage::NewClip>& clips);

storage::OperationRecord SampleOperation(const std::string& database, const std::string& id);

// Returns whether all fields are equal.
bool Same(const storage::DatabaseRecord& a, const storage::DatabaseRecord& b);
bool Same(const storage::ClipRecord& a, const storage::ClipRecord& b);
bool Same(const storage::ModelRecord& a, const storage::ModelRecord& b);
bool Same(const storage::OperationRecord& a, const storage::OperationRecord& b);
// Returns whether the values are bitwise equal, NaN included.
bool Same(const core::StateSequence& a, const core::StateSequence& b);
bool Same(const core::Skeleton& a, const core::Skeleton& b);
bool Same(const core::Model& a, const core::Model& b);

// Returns the encoding that a store uses.
std::string Encoded(const core::StateSequence& states);
std::string Encoded(const core::Skeleton& skeleton);
std::string Encoded(const core::ModelParts& parts);

}  // namespace motiondb::tests
