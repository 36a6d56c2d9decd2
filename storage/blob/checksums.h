// Checksums: CRC-32 (IEEE 802.3, as in zlib, gzip and PNG) and SHA-256. One Sha256 object computes
// one digest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace motiondb::storage {

// Returns the CRC-32 of a byte sequence that ends with `bytes`; `before` is the CRC-32 of the bytes
// before them.
std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

inline constexpr std::size_t kSha256Bytes = 32;

class Sha256 {
 public:
  Sha256();
  void Update(std::string_view bytes);
  // Returns the digest, kSha256Bytes bytes. Call it once.
  std::string Finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

}  // namespace motiondb::storage
