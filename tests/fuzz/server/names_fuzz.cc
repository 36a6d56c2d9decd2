// Resource names and page tokens: what parses is written the same again.
#include "server/translate/page.h"
#include "server/translate/resource_name.h"
#include "tests/fuzz/support/properties.h"
#include "text/utf8.h"

using namespace motiondb;

namespace {

constexpr char kScope[] = "databases/db/models";

void HoldsNames(const std::string& name) {
  const auto database = server::ParseDatabaseName("name", name);
  tests::HoldsError(database.status(), absl::StatusCode::kInvalidArgument);
  if (database.ok()) tests::Holds(server::DatabaseName(*database) == name, "the same database");
  const auto clip = server::ParseClipName("name", name);
  tests::HoldsError(clip.status(), absl::StatusCode::kInvalidArgument);
  if (clip.ok()) tests::Holds(server::ClipName(clip->database, clip->id) == name, "the same clip");
  const auto skeleton = server::ParseSkeletonName("name", name);
  tests::HoldsError(skeleton.status(), absl::StatusCode::kInvalidArgument);
  const auto model = server::ParseModelName("name", name);
  tests::HoldsError(model.status(), absl::StatusCode::kInvalidArgument);
  if (model.ok()) tests::Holds(model->version >= 0, "a version is not negative");
  const auto operation = server::ParseOperationName("name", name);
  tests::HoldsError(operation.status(), absl::StatusCode::kInvalidArgument);
  tests::HoldsError(server::CheckDatabaseId("id", name), absl::StatusCode::kInvalidArgument);
  tests::HoldsError(server::CheckClipId("id", name), absl::StatusCode::kInvalidArgument);
}

void HoldsTokens(const std::string& text) {
  const auto position = server::DecodePageToken(kScope, text);
  tests::HoldsError(position.status(), absl::StatusCode::kInvalidArgument);
  if (position.ok() && !position->empty()) {
    // The same text need not be: base64 may be padded and broken into lines.
    const auto again = server::DecodePageToken(kScope, server::EncodePageToken(kScope, *position));
    tests::Holds(again.ok() && *again == *position, "the same position");
  }
  const auto in_model = server::DecodeModelPosition(kScope, text);
  tests::HoldsError(in_model.status(), absl::StatusCode::kInvalidArgument);
  // A token that the list itself could have given out around this position.
  const auto around = server::DecodeModelPosition(kScope, server::EncodePageToken(kScope, text));
  tests::HoldsError(around.status(), absl::StatusCode::kInvalidArgument);
  if (around.ok()) tests::Holds(around->index >= 0, "a list does not begin before its start");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(tests::AsText(data, size));
  HoldsNames(text);
  HoldsTokens(text);
  const std::string valid = text::ValidUtf8(text);
  tests::Holds(text::ValidUtf8(valid) == valid, "valid text stays as it is");
  tests::Holds(text::ValidUtf8(text, 100).size() <= 100, "text is cut to its limit");
  return 0;
}
