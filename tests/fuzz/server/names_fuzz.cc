// Resource names and page tokens: formatting a parsed text returns the same text.
#include "server/engine/ingest_rules.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"
#include "tests/fuzz/support/properties.h"
#include "text/utf8.h"

using namespace motiondb;

namespace {

constexpr char kScope[] = "databases/db/models";

void HoldsNames(const std::string& name) {
  const auto database = server::ParseDatabaseName("name", name);
  tests::CheckErrorContract(database.status(), absl::StatusCode::kInvalidArgument);
  if (database.ok())
    tests::CheckContract(server::DatabaseName(*database) == name, "a database name round-trips");
  const auto clip = server::ParseClipName("name", name);
  tests::CheckErrorContract(clip.status(), absl::StatusCode::kInvalidArgument);
  if (clip.ok())
    tests::CheckContract(server::ClipName(clip->database, clip->id) == name,
                         "a clip name round-trips");
  const auto skeleton = server::ParseSkeletonName("name", name);
  tests::CheckErrorContract(skeleton.status(), absl::StatusCode::kInvalidArgument);
  const auto model = server::ParseModelName("name", name);
  tests::CheckErrorContract(model.status(), absl::StatusCode::kInvalidArgument);
  if (model.ok()) tests::CheckContract(model->version >= 0, "a version is not negative");
  const auto operation = server::ParseOperationName("name", name);
  tests::CheckErrorContract(operation.status(), absl::StatusCode::kInvalidArgument);
  tests::CheckErrorContract(server::CheckDatabaseId("id", name),
                            absl::StatusCode::kInvalidArgument);
  tests::CheckErrorContract(server::CheckClipId("id", name), absl::StatusCode::kInvalidArgument);
}

void HoldsTokens(const std::string& text) {
  const auto position = server::DecodePageToken(kScope, text);
  tests::CheckErrorContract(position.status(), absl::StatusCode::kInvalidArgument);
  if (position.ok() && !position->empty()) {
    // The text may differ: base64 may be padded and split into lines.
    const auto again = server::DecodePageToken(kScope, server::EncodePageToken(kScope, *position));
    tests::CheckContract(again.ok() && *again == *position, "a position round-trips");
  }
  const auto in_model = server::DecodeModelPosition(kScope, text);
  tests::CheckErrorContract(in_model.status(), absl::StatusCode::kInvalidArgument);
  // A token that the list could have returned near this position.
  const auto around = server::DecodeModelPosition(kScope, server::EncodePageToken(kScope, text));
  tests::CheckErrorContract(around.status(), absl::StatusCode::kInvalidArgument);
  if (around.ok()) tests::CheckContract(around->index >= 0, "an index is not negative");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(tests::AsText(data, size));
  HoldsNames(text);
  HoldsTokens(text);
  const std::string valid = text::ValidUtf8(text);
  tests::CheckContract(text::ValidUtf8(valid) == valid, "valid text is unchanged");
  tests::CheckContract(text::ValidUtf8(text, 100).size() <= 100, "text is cut to its limit");
  return 0;
}
