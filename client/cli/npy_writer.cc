#include "client/cli/npy_writer.h"

#include <fmt/format.h>

#include <utility>

#include "client/cli/count_text.h"

namespace motiondb::client {
namespace {

constexpr int64_t kElementBytes = 4;
constexpr size_t kAlignment = 64;
// "\x93NUMPY", two bytes of version, two of length.
constexpr size_t kPreambleBytes = 10;

int64_t ElementCount(const std::vector<int64_t>& shape) {
  int64_t count = 1;
  for (const int64_t extent : shape) count *= extent;
  return count;
}

}  // namespace

std::string NpyHeader(NpyType type, const std::vector<int64_t>& shape) {
  std::string extents;
  for (const int64_t extent : shape) extents += fmt::format("{}, ", extent);
  // One extent keeps its comma, as Python writes a tuple of one.
  extents.resize(extents.size() - (shape.size() == 1 ? 1 : 2));
  std::string description =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                  type == NpyType::kFloat32 ? "<f4" : "<i4", extents);
  const size_t used = kPreambleBytes + description.size() + 1;
  description.append((kAlignment - used % kAlignment) % kAlignment, ' ');
  description += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(description.size() & 0xFF);
  header += static_cast<char>(description.size() >> 8);
  return header + description;
}

NpyWriter::NpyWriter(std::filesystem::path path, NpyType type, std::vector<int64_t> shape)
    : path_(std::move(path)),
      missing_bytes_(ElementCount(shape) * kElementBytes),
      file_(OutputFile::Create(path_)) {
  Write(NpyHeader(type, shape));
}

void NpyWriter::Write(std::string_view bytes) {
  if (!file_.ok()) return;
  if (absl::Status written = file_->Append(bytes); !written.ok()) file_ = written;
}

void NpyWriter::AppendBytes(std::string_view bytes) {
  Write(bytes);
  missing_bytes_ -= static_cast<int64_t>(bytes.size());
}

void NpyWriter::Append(int32_t value) {
  const auto bits = static_cast<uint32_t>(value);
  const char bytes[kElementBytes] = {static_cast<char>(bits), static_cast<char>(bits >> 8),
                                     static_cast<char>(bits >> 16), static_cast<char>(bits >> 24)};
  AppendBytes(std::string_view(bytes, kElementBytes));
}

absl::Status NpyWriter::Finish() {
  if (!file_.ok()) return file_.status();
  if (missing_bytes_ != 0) {
    return absl::DataLossError(fmt::format("{}: the server sent {} too {}", path_.string(),
                                           CountText(std::abs(missing_bytes_), "byte"),
                                           missing_bytes_ > 0 ? "few" : "many"));
  }
  return file_->Commit(/*replace=*/true);
}

}  // namespace motiondb::client
