// Clips and skeletons as messages. Safe to call from any thread.
#pragma once

#include "storage/records.h"

namespace motiondb::v1 {
class Clip;
class Skeleton;
}  // namespace motiondb::v1

namespace motiondb::server {

void SetClip(const storage::ClipRecord& record, v1::Clip& message);
void SetSkeleton(const std::string& database, const storage::SkeletonRecord& record,
                 v1::Skeleton& message);

}  // namespace motiondb::server
