#include "client/cli/whole_file.h"

#include "client/output_file.h"

namespace motiondb::client {

absl::Status WriteWholeFile(const std::filesystem::path& path, std::string_view bytes) {
  auto file = OutputFile::Create(path);
  if (!file.ok()) return file.status();
  if (const absl::Status written = file->Append(bytes); !written.ok()) return written;
  return file->Commit(/*replace=*/true);
}

}  // namespace motiondb::client
