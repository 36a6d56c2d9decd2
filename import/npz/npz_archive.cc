#include "import/npz/npz_archive.h"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <utility>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {
namespace {

constexpr zip_int64_t kMaxMembers = 1000;
constexpr std::string_view kNpyExtension = ".npy";
constexpr std::size_t kNpzReadBytes = std::size_t{1} << 18;

// The error of a file without the directory that ends an archive.
absl::Status NoDirectory(core::SourceFile file) {
  if (file.bytes.starts_with("PK\x03\x04")) {
    return core::InvalidArgument(
        "{}: expected the directory of the archive before byte {}, its end: it is truncated",
        file.name, file.bytes.size());
  }
  return core::InvalidArgument("{}: byte 0: expected a NumPy archive (zip), found '{}'", file.name,
                               core::Shown(file.bytes.substr(0, 4)));
}

struct CloseMember {
  void operator()(zip_file_t* member) const { zip_fclose(member); }
};

}  // namespace

void NpzArchive::CloseArchive::operator()(zip* archive) const { zip_discard(archive); }

absl::StatusOr<NpzArchive> NpzArchive::Open(core::SourceFile file, std::size_t max_bytes) {
  // libzip takes no bytes for a new archive.
  if (file.bytes.empty()) {
    return core::InvalidArgument("{}: expected a NumPy archive (zip), found no byte", file.name);
  }
  zip_error_t error;
  zip_error_init(&error);
  const auto failure = [&] {
    const int code = zip_error_code_zip(&error);
    const std::string reason =
        code == ZIP_ER_EXISTS ? "two members have the same name" : zip_error_strerror(&error);
    zip_error_fini(&error);
    if (code == ZIP_ER_NOZIP) return NoDirectory(file);
    return core::InvalidArgument("{}: expected a NumPy archive (zip): {}", file.name,
                                 core::Shown(reason));
  };
  zip_source_t* source = zip_source_buffer_create(file.bytes.data(), file.bytes.size(), 0, &error);
  if (source == nullptr) return failure();
  NpzArchive archive;
  archive.file_name_ = std::string(file.name);
  archive.max_bytes_ = max_bytes;
  // CHECKCONS compares each member's header with the directory, and finds repeated names.
  archive.archive_.reset(zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error));
  if (archive.archive_ == nullptr) {
    zip_source_free(source);
    return failure();
  }
  zip_error_fini(&error);
  MOTIONDB_RETURN_IF_ERROR(archive.ListMembers());
  return archive;
}

absl::Status NpzArchive::ListMembers() {
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  if (count > kMaxMembers) {
    return core::InvalidArgument("{}: expected at most {} members, found {}", file_name_,
                                 kMaxMembers, count);
  }
  for (zip_int64_t i = 0; i < count; ++i) {
    const auto index = static_cast<zip_uint64_t>(i);
    zip_stat_t stat;
    if (zip_stat_index(archive_.get(), index, ZIP_FL_ENC_RAW, &stat) != 0 ||
        (stat.valid & ZIP_STAT_NAME) == 0) {
      return core::InvalidArgument("{}: member {} has no name", file_name_, i);
    }
    std::string name = stat.name;
    if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) != 0 && stat.encryption_method != ZIP_EM_NONE) {
      return core::InvalidArgument("{}: member '{}' is encrypted", file_name_, core::Shown(name));
    }
    if (!name.ends_with(kNpyExtension)) continue;
    name.resize(name.size() - kNpyExtension.size());
    arrays_.push_back({.name = std::move(name), .index = index});
  }
  return absl::OkStatus();
}

std::vector<std::string> NpzArchive::names() const {
  std::vector<std::string> names;
  names.reserve(arrays_.size());
  for (const Member& member : arrays_) names.push_back(member.name);
  return names;
}

bool NpzArchive::Has(std::string_view name) const {
  return std::ranges::find(arrays_, name, &Member::name) != arrays_.end();
}

absl::StatusOr<NpyArray> NpzArchive::Read(std::string_view name) {
  const auto found = std::ranges::find(arrays_, name, &Member::name);
  if (found == arrays_.end()) {
    return core::InvalidArgument("{}: there is no array '{}'", file_name_, core::Shown(name));
  }
  auto array = ReadMember(found->index);
  if (array.ok()) return array;
  const std::string_view reason(array.status().message().data(), array.status().message().size());
  return core::InvalidArgument("{}: array '{}': {}", file_name_, core::Shown(name), reason);
}

absl::Status NpzArchive::Decompress(void* member, std::size_t size, std::string& bytes) {
  auto* file = static_cast<zip_file_t*>(member);
  while (bytes.size() < size) {
    const std::size_t begin = bytes.size();
    const std::size_t wanted = std::min(size - begin, kNpzReadBytes);
    bytes.resize(begin + wanted);
    const zip_int64_t count = zip_fread(file, bytes.data() + begin, wanted);
    if (count < 0) {
      return core::InvalidArgument("byte {}: it cannot be decompressed: {}", begin,
                                   core::Shown(zip_file_strerror(file)));
    }
    bytes.resize(begin + static_cast<std::size_t>(count));
    decompressed_ += static_cast<std::size_t>(count);
    if (decompressed_ > max_bytes_) {
      return core::InvalidArgument("the archive has more than {} decompressed bytes", max_bytes_);
    }
    if (count == 0) break;  // the end; libzip has compared the checksum
  }
  return absl::OkStatus();
}

absl::StatusOr<NpyArray> NpzArchive::ReadMember(std::uint64_t index) {
  zip_stat_t stat;
  if (zip_stat_index(archive_.get(), index, 0, &stat) != 0 ||
      (stat.valid & ZIP_STAT_COMP_METHOD) == 0) {
    return core::InvalidArgument("its directory entry is incomplete");
  }
  if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE) {
    return core::InvalidArgument("expected the compression deflate or none, found method {}",
                                 stat.comp_method);
  }
  const std::unique_ptr<zip_file_t, CloseMember> member(zip_fopen_index(archive_.get(), index, 0));
  if (member == nullptr) {
    return core::InvalidArgument("it cannot be opened: {}",
                                 core::Shown(zip_strerror(archive_.get())));
  }
  std::string bytes;
  MOTIONDB_RETURN_IF_ERROR(Decompress(member.get(), kMaxNpyHeader, bytes));
  MOTIONDB_ASSIGN_OR_RETURN(NpyHeader header, ParseNpyHeader(bytes));

  const std::size_t data = header.data_bytes();
  if (data > max_bytes_) {
    return core::InvalidArgument("its shape {} needs {} bytes, above the limit of {}",
                                 ShapeText(header.shape), data, max_bytes_);
  }
  // One byte more than the data shows data that are too long, and is the end otherwise.
  MOTIONDB_RETURN_IF_ERROR(Decompress(member.get(), header.data_offset + data + 1, bytes));
  if (bytes.size() != header.data_offset + data) {
    return core::InvalidArgument("byte {}: expected {} bytes of data for the shape {}, found {}",
                                 header.data_offset, data, ShapeText(header.shape),
                                 bytes.size() > header.data_offset + data
                                     ? "more"
                                     : fmt::format("{}", bytes.size() - header.data_offset));
  }
  return NpyArray(std::move(header), std::move(bytes));
}

}  // namespace motiondb::importer
