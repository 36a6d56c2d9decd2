#include "import/npz/npz_reader.h"

#include "core/motion/error.h"
#include "import/npz/npz_archive.h"
#include "import/npz/npz_values.h"

namespace motiondb::importer {

absl::StatusOr<core::MotionFile> ReadNpz(core::SourceFile file, const core::ReadOptions& options,
                                         std::size_t max_bytes) {
  MOTIONDB_ASSIGN_OR_RETURN(NpzArchive archive, NpzArchive::Open(file, max_bytes));
  const NpzSource source{.archive = archive, .file_name = file.name, .max_bytes = max_bytes};
  if (archive.Has("motiondb_version")) return ReadMotiondbNpz(source, options);
  if (IsSmpl(archive)) return ReadSmpl(source, options);
  return core::InvalidArgument(
      "{}: expected the arrays of AMASS or SMPL (poses, trans), AIST++ (smpl_poses, smpl_trans) or "
      "motiondb (motiondb_version); found {}",
      file.name, ArrayList(archive));
}

}  // namespace motiondb::importer
