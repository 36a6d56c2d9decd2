#include "client/cli/operation_text.h"

#include <fmt/format.h>
#include <motiondb/v1/operation.pb.h>

#include "client/cli/database_text.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

std::string OperationStateText(const v1::Operation& operation) {
  return EnumValueText(v1::OperationState_Name(operation.state()));
}

Style StyleOf(const v1::Operation& operation) {
  switch (operation.state()) {
    case v1::OPERATION_STATE_SUCCEEDED:
      return Style::kGood;
    case v1::OPERATION_STATE_FAILED:
      return Style::kError;
    case v1::OPERATION_STATE_CANCELLED:
      return Style::kWarning;
    default:
      return Style::kPlain;
  }
}

}  // namespace

Table OperationsTable(const std::vector<v1::Operation>& operations) {
  Table table({{"OPERATION"},
               {"DATABASE"},
               {"KIND"},
               {"STATE"},
               {"DONE (%)", Align::kRight},
               {"STAGE"},
               {"MODEL", Align::kRight},
               {"CREATED"},
               {"ERROR"}});
  for (const v1::Operation& operation : operations) {
    table.AddRow({ShortName(operation.name()), ShortName(operation.database()),
                  EnumValueText(v1::OperationKind_Name(operation.kind())),
                  Cell(OperationStateText(operation), StyleOf(operation)),
                  Cell(operation.progress() * 100, 0), operation.stage(),
                  ShortName(ModelOf(operation)), TimeText(operation.create_time()),
                  operation.error().message()});
  }
  return table;
}

}  // namespace motiondb::client
