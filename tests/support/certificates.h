// Creates test certificates with the `openssl` program.
#pragma once

#include <string>

namespace motiondb::tests {

// Paths of a certificate and its key (PEM).
struct KeyPairFiles {
  std::string certificate;
  std::string key;
};

// A certificate authority. REQUIREs that each openssl command succeeds.
class Authority {
 public:
  // Writes its files to `folder`, which must exist. File names begin with `name`.
  Authority(const std::string& folder, const std::string& name);

  const std::string& certificate() const { return own_.certificate; }
  // Issues a certificate for `common_name`, also valid for the servers localhost and 127.0.0.1. It
  // is valid for `days`; a negative value makes an expired one. Overwrites the earlier pair of the
  // same `file`.
  KeyPairFiles Issue(const std::string& file, const std::string& common_name, int days = 2) const;

 private:
  const std::string folder_;
  KeyPairFiles own_;
};

}  // namespace motiondb::tests
