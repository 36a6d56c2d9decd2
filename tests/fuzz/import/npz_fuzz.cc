// NumPy archives. If the first byte is even, the rest is the archive. If it is odd, the rest is a
// sequence of members, each as the length of its name (u8), the length of its content (u16), name
// and content; the archive of these has valid checksums, so that the readers of arrays are reached.
#include <zlib.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "core/export/file_bytes.h"
#include "import/npz/npz_reader.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/motion_properties.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

namespace {

// A zip archive without compression.
class StoredArchive {
 public:
  void Add(std::string_view name, std::string_view content) {
    std::string fields;
    core::AppendWord32(20, fields);          // version 2.0, no flags
    core::AppendWord16(0, fields);           // stored
    core::AppendWord32(0x00210000, fields);  // 1980-01-01
    const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
    core::AppendWord32(static_cast<std::uint32_t>(crc), fields);
    core::AppendWord32(static_cast<std::uint32_t>(content.size()), fields);
    core::AppendWord32(static_cast<std::uint32_t>(content.size()), fields);
    core::AppendWord16(static_cast<std::uint16_t>(name.size()), fields);
    core::AppendWord16(0, fields);  // extra fields
    directory_ += std::string("PK\x01\x02\x14\x00", 6) + fields;
    directory_.append(10, '\0');  // comment, disk, attributes
    core::AppendWord32(static_cast<std::uint32_t>(members_.size()), directory_);
    directory_ += name;
    members_ += "PK\x03\x04" + fields;
    members_ += name;
    members_ += content;
    ++count_;
  }

  std::string Bytes() const {
    std::string end("PK\x05\x06\x00\x00\x00\x00", 8);
    core::AppendWord16(count_, end);
    core::AppendWord16(count_, end);
    core::AppendWord32(static_cast<std::uint32_t>(directory_.size()), end);
    core::AppendWord32(static_cast<std::uint32_t>(members_.size()), end);
    core::AppendWord16(0, end);  // comment
    return members_ + directory_ + end;
  }

 private:
  std::string members_;
  std::string directory_;
  std::uint16_t count_ = 0;
};

std::string_view Take(std::string_view& input, std::size_t length) {
  const std::string_view taken = input.substr(0, length);
  input.remove_prefix(taken.size());
  return taken;
}

std::string ArchiveOf(std::string_view input) {
  StoredArchive archive;
  constexpr std::size_t kLengths = 3;
  while (input.size() >= kLengths) {
    const std::string_view lengths = Take(input, kLengths);
    const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(lengths[i]); };
    const std::string_view name = Take(input, at(0));
    archive.Add(name, Take(input, at(1) + std::size_t{256} * at(2)));
  }
  return archive.Bytes();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::size_t kMaxBytes = 1 << 20;
  const std::string_view input = tests::AsText(data + 1, size - 1);
  const std::string archive = (data[0] & 1) != 0 ? ArchiveOf(input) : std::string(input);
  const tests::MemoryWatch watch;
  const auto read = importer::ReadNpz({"input.npz", archive}, {}, kMaxBytes);
  // Each array while it grows, the motion, and libzip's entries.
  watch.CheckProportional(archive.size(), 4 * kMaxBytes, 200);
  tests::CheckMotionFile(read);
  return 0;
}
