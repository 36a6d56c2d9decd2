// motiondb operations list|wait|cancel
#include <motiondb/v1/operation.pb.h>

#include <vector>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"

namespace motiondb::client {
namespace {

struct OperationsListOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
};

struct OperationOptions {
  std::string operation;
};

void DeclareList(CLI::App& command, OperationsListOptions& options) {
  command.add_option("DB", options.database, "Database; else the operations of all");
}

void DeclareOperation(CLI::App& command, OperationOptions& options) {
  command.add_option("OPERATION", options.operation, "Name in `motiondb operations list`")
      ->required();
}

// Removes error details, because the JSON printer does not know their types. The message contains
// the same information.
v1::Operation Printable(v1::Operation operation) {
  if (operation.has_error()) operation.mutable_error()->clear_details();
  return operation;
}

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

absl::Status RunList(const OperationsListOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListOperationsRequest request;
  if (!options.database.empty()) request.set_parent(DatabaseName(options.database));
  const auto operations = client->AllOperations(request);
  if (!operations.ok()) return operations.status();
  if (global.json) {
    for (const v1::Operation& operation : *operations) PrintJson(Printable(operation));
  } else {
    PrintTable(OperationsTable(*operations), global.csv, "no operations");
  }
  return absl::OkStatus();
}

// Prints an operation, in JSON as the message `Response`.
template <typename Response>
void Print(const v1::Operation& operation, bool json) {
  if (json) {
    Response response;
    *response.mutable_operation() = Printable(operation);
    PrintJson(response);
  } else {
    PrintText(OperationsTable({operation}).ToString());
  }
}

absl::Status RunWait(const OperationOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  ProgressBar bar;
  const auto done = client->WaitOperation(
      OperationName(options.operation),
      [&](const v1::Operation& now) { bar.Show(now.progress(), now.stage()); });
  bar.Clear();
  if (!done.ok()) return done.status();
  Print<v1::WaitOperationResponse>(*done, global.json);
  return OperationStatus(*done);
}

absl::Status RunCancel(const OperationOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::CancelOperationRequest request;
  request.set_name(OperationName(options.operation));
  const auto response = client->CancelOperation(request);
  if (!response.ok()) return response.status();
  Print<v1::CancelOperationResponse>(response->operation(), global.json);
  return absl::OkStatus();
}

}  // namespace

void AddOperationsCommand(CommandLine line) {
  const CommandLine inner =
      AddCommandGroup(line, "operations", "List, wait for or cancel operations",
                      "motiondb operations list walks\nmotiondb operations wait 17");
  AddCommand<OperationsListOptions>(
      inner, "list", "List operations, newest first",
      "motiondb operations list\nmotiondb operations list walks --csv", DeclareList, RunList);
  AddCommand<OperationOptions>(inner, "wait", "Wait until an operation is done; fails if it failed",
                               "motiondb operations wait 17", DeclareOperation, RunWait);
  AddCommand<OperationOptions>(inner, "cancel", "Cancel an operation",
                               "motiondb operations cancel 17", DeclareOperation, RunCancel);
}

}  // namespace motiondb::client
