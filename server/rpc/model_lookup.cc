#include "server/rpc/model_lookup.h"

#include <algorithm>

#include "core/motion/error.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

absl::StatusOr<SnapshotPointer> FindReadable(const Call& call, const ModelId& id) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(id.database));
  MOTIONDB_ASSIGN_OR_RETURN(SnapshotPointer snapshot,
                            call.engine.CurrentModel(*live, call.work_options()));
  const bool is_current = snapshot->is_stored() && id.version == snapshot->record.version;
  if (id.version == 0 || is_current) return snapshot;
  MOTIONDB_RETURN_IF_ERROR(call.engine.store().GetModel(id.database, id.version).status());
  return core::WithReason(
      "MODEL_SUPERSEDED",
      core::FailedPrecondition("model {} of database '{}' was replaced by a newer one, only its "
                               "statistics are stored: read "
                               "{}",
                               id.version, id.database, CurrentModelName(id.database)));
}

absl::StatusOr<int> ClipIndex(const std::string& name, const ModelId& id,
                              const Snapshot& snapshot) {
  if (name.empty()) return -1;
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId clip, ParseClipName("clip", name));
  if (clip.database != id.database) {
    return core::FieldViolation("clip", "expected a clip of databases/{}, got '{}'", id.database,
                                name);
  }
  const auto& clips = snapshot.model.clips();
  const auto found = std::ranges::find(clips, clip.id, &core::ModelClip::id);
  if (found == clips.end()) {
    return core::WithReason("CLIP_NOT_FOUND",
                            core::NotFound("clip '{}' is not in model {} of database '{}'", clip.id,
                                           snapshot.record.version, id.database));
  }
  return static_cast<int>(found - clips.begin());
}

}  // namespace motiondb::server
