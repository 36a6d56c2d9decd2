#include "client/cli/annotate/annotation_options.h"

#include "client/cli/annotate/clip_edit.h"

namespace motiondb::client {
namespace {

CLI::Validator FieldText() {
  return CLI::Validator(
      [](const std::string& text) {
        return std::string(ParseFieldOption(text).status().message());
      },
      "");
}

}  // namespace

void AddRepeatedOption(CLI::App& command, const char* name, std::vector<std::string>& values,
                       const char* type, const char* description) {
  command.add_option(name, values, description)->type_name(type)->allow_extra_args(false);
}

void AddFieldOption(CLI::App& command, std::vector<std::string>& fields, const char* description) {
  command.add_option("--field", fields, description)
      ->type_name("NAME[:TYPE]=VALUE")
      ->allow_extra_args(false)
      ->check(FieldText());
}

}  // namespace motiondb::client
