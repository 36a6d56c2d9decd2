#include "tests/import/npz/npz_files.h"

#include <fmt/format.h>
#include <zlib.h>

#include <catch2/catch.hpp>

namespace motiondb::tests {
namespace {

void PutLittleEndian(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
}

}  // namespace

std::string Npy(std::string_view header, std::string_view data, int version) {
  std::string bytes("\x93NUMPY", 6);
  bytes += static_cast<char>(version);
  bytes += '\0';
  PutLittleEndian(bytes, header.size(), version == 1 ? 2 : 4);
  return bytes + std::string(header) + std::string(data);
}

std::string NpyDictionary(std::string_view type, std::initializer_list<std::size_t> shape,
                          bool fortran_order) {
  std::string sizes;
  for (const std::size_t size : shape) sizes += fmt::format("{}, ", size);
  return fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({}), }}\n", type,
                     fortran_order ? "True" : "False", sizes);
}

std::string Float64Npy(std::initializer_list<std::size_t> shape, const std::vector<double>& data) {
  return Npy(NpyDictionary("<f8", shape), BytesOf<double>(data));
}

std::string TextNpy(std::string_view ascii) {
  std::string data;
  for (const char c : ascii) PutLittleEndian(data, static_cast<unsigned char>(c), 4);
  return Npy(NpyDictionary(fmt::format("<U{}", ascii.size()), {}), data);
}

std::string Deflated(std::string_view content, bool gzip) {
  z_stream stream = {};
  REQUIRE(deflateInit2(&stream, 9, Z_DEFLATED, gzip ? 16 + MAX_WBITS : -MAX_WBITS, 9,
                       Z_DEFAULT_STRATEGY) == Z_OK);
  std::string out(deflateBound(&stream, content.size()), '\0');
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string Zip(const std::vector<ZipMember>& members) {
  std::string out;
  std::string directory;
  std::vector<std::size_t> offsets;
  std::vector<std::string> stored;
  for (const ZipMember& member : members) {
    const std::size_t data = member.same_data_as.value_or(stored.size());
    stored.push_back(member.deflated ? Deflated(member.content, false) : member.content);
    offsets.push_back(member.same_data_as ? offsets[data] : out.size());
    std::string fields;
    PutLittleEndian(fields, 20, 2);
    PutLittleEndian(fields, static_cast<unsigned>(member.flags), 2);
    PutLittleEndian(fields, static_cast<unsigned>(member.method.value_or(member.deflated ? 8 : 0)),
                    2);
    PutLittleEndian(fields, 0x00210000, 4);  // 1980-01-01
    const uLong crc =
        crc32_z(0, reinterpret_cast<const Bytef*>(member.content.data()), member.content.size());
    PutLittleEndian(fields, member.stated_crc.value_or(static_cast<std::uint32_t>(crc)), 4);
    PutLittleEndian(fields, stored.back().size(), 4);
    PutLittleEndian(
        fields, member.stated_size.value_or(static_cast<std::uint32_t>(member.content.size())), 4);
    PutLittleEndian(fields, member.name.size(), 2);
    PutLittleEndian(fields, 0, 2);
    if (!member.same_data_as) out += "PK\x03\x04" + fields + member.name + stored.back();
    directory += std::string("PK\x01\x02\x14\x00", 6) + fields;
    directory.append(10, '\0');  // comment, disk, attributes
    PutLittleEndian(directory, offsets.back(), 4);
    directory += member.name;
  }
  std::string end("PK\x05\x06\x00\x00\x00\x00", 8);
  PutLittleEndian(end, members.size(), 2);
  PutLittleEndian(end, members.size(), 2);
  PutLittleEndian(end, directory.size(), 4);
  PutLittleEndian(end, out.size(), 4);
  PutLittleEndian(end, 0, 2);
  return out + directory + end;
}

}  // namespace motiondb::tests
