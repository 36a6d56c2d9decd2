// Changes of a clip's label, subject, title, description, tags and fields, as the command line and
// lists give them.
#pragma once

#include <motiondb/v1/clip.pb.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace CLI {
class App;
}  // namespace CLI

namespace motiondb::client {

struct ClipEdit {
  std::optional<std::string> label;
  std::optional<std::string> subject;
  std::optional<std::string> title;
  std::optional<std::string> description;
  std::vector<std::string> tags;  // to add
  std::vector<std::string> removed_tags;
  std::map<std::string, v1::FieldValue> fields;
  std::vector<std::string> removed_fields;

  bool empty() const;
  bool ChangesTags() const { return !tags.empty() || !removed_tags.empty(); }
};

// Returns the request that makes the change. Tags are added to and removed from those of `stored`,
// which must have its etag then: the request has it, so that no tag of another writer is lost.
// Otherwise `stored` needs only its name.
v1::UpdateClipRequest UpdateRequest(const ClipEdit& edit, const v1::Clip& stored);

// Returns the value of a text: true or false, a finite number, a time (RFC 3339), or else the text.
v1::FieldValue GuessFieldValue(const std::string& text);

// Returns name and value of "NAME" or "NAME:TYPE", TYPE one of text, number, flag, time, and a
// text. INVALID_ARGUMENT: no name, an unknown type, or a text that is not of the type.
absl::StatusOr<std::pair<std::string, v1::FieldValue>> ParseField(const std::string& name_and_type,
                                                                  const std::string& text);

// As ParseField, for "NAME=VALUE" or "NAME:TYPE=VALUE".
absl::StatusOr<std::pair<std::string, v1::FieldValue>> ParseFieldOption(const std::string& option);

// Returns the value as text: "true", "1.5", "2026-01-31T10:00:00Z".
std::string FieldValueText(const v1::FieldValue& value);

// Adds an option with one value that may be repeated.
void AddRepeatedOption(CLI::App& command, const char* name, std::vector<std::string>& values,
                       const char* type, const char* description);

// Adds --field NAME[:TYPE]=VALUE, repeated; see ParseFieldOption.
void AddFieldOption(CLI::App& command, std::vector<std::string>& fields, const char* description);

}  // namespace motiondb::client
