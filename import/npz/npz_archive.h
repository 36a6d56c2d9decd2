// Reads arrays from a NumPy archive (.npz): a zip archive of .npy members. Uses libzip, which reads
// from memory here; it opens no file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "import/npz/npy_array.h"

struct zip;  // of libzip

namespace motiondb::importer {

// Not thread-safe.
class NpzArchive {
 public:
  // Lists the members; decompresses nothing. `file` must outlive the archive. `max_bytes`: limit of
  // the decompressed bytes of all Read together, counted as they come out of the decompressor, so
  // that wrong sizes, overlapping members and repeated reads do not pass it.
  //
  // INVALID_ARGUMENT, beginning with the file's name: not a zip archive, truncated, inconsistent,
  // more than 1000 members, two members of one name, or an encrypted member.
  static absl::StatusOr<NpzArchive> Open(core::SourceFile file, std::size_t max_bytes);

  // Names of the arrays, without ".npy", in the archive's order. Other members are ignored.
  std::vector<std::string> names() const;
  bool Has(std::string_view name) const;

  // Decompresses one array and checks its checksum. INVALID_ARGUMENT "FILE: array 'NAME': ...":
  // there is no such array, its header is not read (ParseNpyHeader), its data do not have the size
  // of its shape, it is compressed by another method than deflate, or it exceeds the limit.
  absl::StatusOr<NpyArray> Read(std::string_view name);

 private:
  struct Member {
    std::string name;
    std::uint64_t index = 0;
  };
  struct CloseArchive {
    void operator()(zip* archive) const;
  };

  NpzArchive() = default;
  absl::Status ListMembers();
  // Appends decompressed bytes until there are `size`, or to the member's end.
  absl::Status Decompress(void* member, std::size_t size, std::string& bytes);
  absl::StatusOr<NpyArray> ReadMember(std::uint64_t index);

  std::string file_name_;
  std::size_t max_bytes_ = 0;
  std::size_t decompressed_ = 0;
  std::unique_ptr<zip, CloseArchive> archive_;
  std::vector<Member> arrays_;
};

}  // namespace motiondb::importer
