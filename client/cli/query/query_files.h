// Asks a query for each of several files and prints the answers: as text, JSON or CSV. Also asks
// for a generation profile, which needs several queries.
#pragma once

#include <google/protobuf/message.h>
#include <motiondb/client.h>
#include <motiondb/v1/query.pb.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/cli/plot/canvas.h"
#include "client/cli/query/query_options.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

// One of the files, and where its answers go.
class QueriedFile {
 public:
  QueriedFile(const GlobalOptions& global, std::string name, v1::Observation observation,
              bool& is_first)
      : global_(global),
        name_(std::move(name)),
        observation_(std::move(observation)),
        is_first_(is_first) {}

  // Returns the content of the file, once.
  v1::Observation TakeObservation() { return std::move(observation_); }

  // Prints an answer for the file, one line of JSON, text that `text` returns, or the rows of the
  // table that `table` returns. If the command line names several files, the answer has its name.
  void Print(const google::protobuf::Message& answer, const std::function<std::string()>& text,
             const std::function<Table()>& table);

 private:
  const GlobalOptions& global_;
  const std::string name_;  // empty if the command line names only one file
  v1::Observation observation_;
  bool& is_first_;  // nothing was printed
  bool has_heading_ = false;
};

// Calls `ask` for each file that the options name. A file that cannot be read or that the server
// rejects does not stop the others; it is reported at the end, and the result is an error. Other
// errors stop. The command line names one file if its only FILE is a file, not a folder, a pattern
// or "-". `options_of_one`: given options that need one file; else empty.
absl::Status AskForFiles(
    const QueryOptions& options, const GlobalOptions& global,
    const std::function<absl::Status(const Client& client, QueriedFile& file)>& ask,
    const std::string& options_of_one = "");

// Asks for all clips by the paper's method at each layer, and returns the picture. No layers: the
// bottom layer, a middle and an upper one. Ignores method, layer and number of clips of `request`.
absl::StatusOr<Canvas> AskForProfile(const Client& client, v1::RecognizeRequest request,
                                     const std::vector<int>& layers);

}  // namespace motiondb::client
