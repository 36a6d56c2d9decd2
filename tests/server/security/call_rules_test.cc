// Compares the role table with the .proto files: every RPC has a row, every row has an RPC, and the
// fields of all rows exist.
#include "server/security/call_rules.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/rpc/call_identity.h"
#include "server/translate/message_fields.h"
#include "tests/support/project_paths.h"
#include "tests/support/real_data.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::call_rules_test {
namespace {

using google::protobuf::FileDescriptor;
using google::protobuf::MethodDescriptor;

// Reads the .proto files, to find also RPCs that no program links.
class Contract {
 public:
  Contract() {
    const TemporaryDirectory directory;
    const std::string file = directory / "contract";
    const std::string proto = SourcePath("proto");
    const std::string command = "protoc -I " + proto +
                                " --include_imports --descriptor_set_out=" + file + " " + proto +
                                "/motiondb/v1/*.proto";
    INFO(command);
    REQUIRE(std::system(command.c_str()) == 0);
    google::protobuf::FileDescriptorSet files;
    REQUIRE(files.ParseFromString(ReadFile(file)));
    for (const auto& each : files.file()) {
      const FileDescriptor* const built = pool_.BuildFile(each);
      REQUIRE(built != nullptr);
      for (int i = 0; i < built->service_count(); ++i) {
        for (int j = 0; j < built->service(i)->method_count(); ++j) {
          methods_.push_back(built->service(i)->method(j));
        }
      }
    }
  }
  const std::vector<const MethodDescriptor*>& methods() const { return methods_; }

 private:
  google::protobuf::DescriptorPool pool_;
  std::vector<const MethodDescriptor*> methods_;
};

std::string NameOf(const MethodDescriptor& method) {
  return method.service()->name() + "." + method.name();
}

TEST_CASE("Role table: has exactly one row for every RPC", "[security]") {
  const Contract contract;
  REQUIRE(contract.methods().size() >= 36);
  std::set<std::string> names;
  for (const MethodDescriptor* const method : contract.methods()) {
    INFO(method->full_name());
    CHECK(method->file()->package() == "motiondb.v1");
    CHECK(server::FindCallRule(NameOf(*method)) != nullptr);
    names.insert(NameOf(*method));
  }
  for (const server::CallRule& rule : server::CallRules()) {
    INFO(rule.method);
    CHECK(names.contains(std::string(rule.method)));
  }
  CHECK(server::CallRules().size() == names.size());
}

TEST_CASE("Role table: fields exist in the requests, and scopes have their fields", "[security]") {
  const Contract contract;
  for (const MethodDescriptor* const method : contract.methods()) {
    INFO(method->full_name());
    const server::CallRule& rule = *server::FindCallRule(NameOf(*method));
    const bool one_database =
        rule.scope == server::Scope::kDatabase || rule.scope == server::Scope::kOperation;
    CHECK((!one_database || !rule.field.empty()));
    if (rule.field.empty()) continue;
    CHECK(server::FindTextField(*method->input_type(), rule.field) != nullptr);
  }
}

TEST_CASE("Role table: calls that change something or copy all are recorded", "[security]") {
  // Read-only calls of admins.
  const std::set<std::string_view> looks = {
      "AccessService.ListTokens", "AccessService.ListAuditEntries", "StoreService.VerifyStore"};
  for (const server::CallRule& rule : server::CallRules()) {
    INFO(rule.method);
    const bool is_copy = rule.method == "StoreService.ExportDatabase";  // of a whole database
    CHECK(rule.recorded ==
          (is_copy || (rule.min_role > storage::Role::kReader && !looks.contains(rule.method))));
  }
}

TEST_CASE("Method: every request type belongs to one RPC", "[security]") {
  const Contract contract;
  std::set<std::string> types;
  for (const MethodDescriptor* const method : contract.methods()) {
    INFO(method->full_name());
    CHECK(types.insert(method->input_type()->full_name()).second);
    CHECK(server::FindMethod(*method->input_type()).name == NameOf(*method));
  }
  CHECK(server::MethodOf<v1::IngestClipRequest>().name == "ClipService.IngestClip");
  CHECK(server::MethodOf<v1::PlanRequest>().rule == server::FindCallRule("QueryService.Plan"));
  CHECK(server::FindMethod(*v1::Clip::descriptor()).rule == nullptr);
}

}  // namespace
}  // namespace motiondb::tests::call_rules_test
