// Answers requests to inspect files, each in a child process, as JSON.
#pragma once

#include <cstdio>
#include <istream>
#include <list>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/inspection/inspection.h"
#include "import/child.h"
#include "import/file_request.h"

namespace motiondb::importer {

// Returns the result, or the error, as a JSON object in one line.
std::string InspectionJson(const absl::StatusOr<core::Inspection>& inspection);

// Returns a JSON array of all formats: name, extensions, description, skeleton (extension of its
// skeleton file), has_takes, is_written.
std::string FormatsJson();

// Returns the answer to the request with this index, from 0: index, file and `result`, a JSON
// object from a child process. A result that is no JSON object in one line becomes an error: a
// child may be in the hands of its file.
std::string AnswerLine(int index, const std::string& file, const std::string& result);

struct InspectorOptions {
  int jobs = 2;  // files at the same time
  FileLimits limits;
};

class Inspector {
 public:
  // Writes the answers to `output`.
  Inspector(const InspectorOptions& options, std::FILE* output)
      : options_(options), output_(output) {}

  // Answers one request per line, in any order. UNAVAILABLE if no child process or sandbox can be
  // made, or if the output cannot be written.
  absl::Status Run(std::istream& requests);

 private:
  // A request in a child process.
  struct Job {
    int index;
    FileRequest request;
    core::FileFormat format;
    Child child;
  };

  absl::Status Begin(int index, const std::string& line);
  // Errors are those of the file, but UNAVAILABLE.
  absl::Status Start(int index, const FileRequest& request);
  // Reads from the children until one has ended, and answers its request.
  absl::Status AwaitOne();
  absl::Status Answer(int index, const std::string& file, const std::string& result);

  const InspectorOptions options_;
  std::FILE* const output_;
  std::list<Job> jobs_;
};

}  // namespace motiondb::importer
