// Builds NumPy archives byte by byte, also invalid ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::tests {

// Returns a .npy member with this dictionary as its header.
std::string Npy(std::string_view header, std::string_view data, int version = 1);

// Returns the header of a C order array: {'descr': '<f8', ...}.
std::string NpyDictionary(std::string_view type, std::initializer_list<std::size_t> shape,
                          bool fortran_order = false);

// Returns numbers as the bytes of an array of T.
template <typename T>
std::string BytesOf(const std::vector<double>& numbers, bool big_endian = false) {
  std::string bytes;
  for (const double number : numbers) {
    const T value = static_cast<T>(number);
    char item[sizeof(T)];
    std::memcpy(item, &value, sizeof(T));
    if (big_endian) {
      for (std::size_t i = sizeof(T); i-- > 0;) bytes += item[i];
    } else {
      bytes.append(item, sizeof(T));
    }
  }
  return bytes;
}

std::string Float64Npy(std::initializer_list<std::size_t> shape, const std::vector<double>& data);
// One text, "<U".
std::string TextNpy(std::string_view ascii);

struct ZipMember {
  std::string name;  // with ".npy"
  std::string content;
  bool deflated = false;
  int flags = 0;
  std::optional<int> method = {};                 // else by `deflated`
  std::optional<std::uint32_t> stated_size = {};  // decompressed, in both headers
  std::optional<std::uint32_t> stated_crc = {};
  // Index of an earlier member whose data the directory entry refers to: no data of its own.
  std::optional<std::size_t> same_data_as = {};
};

std::string Zip(const std::vector<ZipMember>& members);

// Deflate without header (for zip) or with a gzip header.
std::string Deflated(std::string_view content, bool gzip);

}  // namespace motiondb::tests
