#include "tests/support/certificates.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>

namespace motiondb::tests {
namespace {

void Openssl(const std::string& arguments) {
  const std::string command = "openssl " + arguments + " 2>/dev/null";
  INFO(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

// Elliptic curve keys are generated in about 1 ms.
constexpr char kNewKey[] = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes";

}  // namespace

Authority::Authority(const std::string& folder, const std::string& name)
    : folder_(folder), own_{folder + "/" + name + ".crt", folder + "/" + name + ".key"} {
  Openssl("req -x509 " + std::string(kNewKey) + " -days 2 -subj /CN=" + name + " -keyout " +
          own_.key + " -out " + own_.certificate);
}

KeyPairFiles Authority::Issue(const std::string& file, const std::string& common_name,
                              int days) const {
  const std::string base = folder_ + "/" + file;
  const KeyPairFiles made{base + ".crt", base + ".key"};
  std::ofstream(base + ".ext") << "subjectAltName = DNS:localhost, IP:127.0.0.1\n";
  Openssl("req " + std::string(kNewKey) + " -subj /CN=" + common_name + " -keyout " + made.key +
          " -out " + base + ".csr");
  Openssl("x509 -req -days " + std::to_string(days) + " -in " + base + ".csr -CA " +
          own_.certificate + " -CAkey " + own_.key + " -CAcreateserial -extfile " + base +
          ".ext -out " + made.certificate);
  return made;
}

}  // namespace motiondb::tests
