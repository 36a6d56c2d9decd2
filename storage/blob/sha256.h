// SHA-256, as libcrypto computes it. Not thread-safe; one object serves one digest.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace motiondb::storage {

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
