// Checksums: CRC-32 (IEEE 802.3, as in zlib, gzip and PNG), which keeps no state, and SHA-256, as
// libcrypto computes it. Not thread-safe; one Sha256 serves one digest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace motiondb::storage {

// Of bytes that follow others whose CRC-32 is `before`.
std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

inline constexpr std::size_t kSha256Bytes = 32;

class Sha256 {
 public:
  Sha256();
  void Update(std::string_view bytes);
  // The digest, kSha256Bytes bytes. To be called once.
  std::string Finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

}  // namespace motiondb::storage
