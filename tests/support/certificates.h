// Certificates that a test makes, with the `openssl` program.
#pragma once

#include <string>

namespace motiondb::tests {

// Paths of a certificate and its key, PEM.
struct KeyPairFiles {
  std::string certificate;
  std::string key;
};

// Signs certificates. REQUIREs that openssl does what it is asked for.
class Authority {
 public:
  // Its files lie in `folder`, which must exist, and begin with `name`.
  Authority(const std::string& folder, const std::string& name);

  const std::string& certificate() const { return own_.certificate; }
  // For `common_name`; as a server's it is good for localhost and 127.0.0.1. Replaces what an
  // earlier call for the same `file` made. It is good for `days`; less than 0: it has expired.
  KeyPairFiles Issue(const std::string& file, const std::string& common_name, int days = 2) const;

 private:
  const std::string folder_;
  KeyPairFiles own_;
};

}  // namespace motiondb::tests
