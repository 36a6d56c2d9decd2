// Writes the HTTP API as OpenAPI, at build time: motiondb_openapi DESCRIPTORS VERSION JSON CC
//
// DESCRIPTORS: a FileDescriptorSet of protoc with imports and source info. CC: C++ that defines
// motiondb::server::kOpenApiJson.
#include <fmt/format.h>
#include <google/protobuf/descriptor.pb.h>

#include <fstream>
#include <string>

#include "server/gateway/openapi.h"

namespace {

constexpr std::size_t kPieceBytes = 8 << 10;  // compilers limit the length of a literal

std::string SourceOf(const std::string& json) {
  std::string source =
      "#include \"server/gateway/openapi.h\"\n\nnamespace motiondb::server {\n\n"
      "const std::string_view kOpenApiJson =";
  for (std::size_t at = 0; at < json.size(); at += kPieceBytes) {
    source += "\n    \"";
    for (const char c : json.substr(at, kPieceBytes)) {
      source += fmt::format("\\{:03o}", static_cast<unsigned char>(c));
    }
    source += '"';
  }
  return source + ";\n\n}  // namespace motiondb::server\n";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  google::protobuf::FileDescriptorSet files;
  std::ifstream input(argv[1], std::ios::binary);
  if (!files.ParseFromIstream(&input)) {
    fmt::print(stderr, "{}: expected a FileDescriptorSet\n", argv[1]);
    return 1;
  }
  const auto document = motiondb::server::OpenApiDocument(files, argv[2]);
  if (!document.ok()) {
    fmt::print(stderr, "{}\n", std::string(document.status().message()));
    return 1;
  }
  const bool json = (std::ofstream(argv[3]) << *document << "\n").flush().good();
  const bool source = (std::ofstream(argv[4]) << SourceOf(*document)).flush().good();
  return json && source ? 0 : 1;
}
