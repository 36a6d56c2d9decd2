// Answers requests to inspect files, each in a child process.
#pragma once

#include <cstdio>
#include <istream>
#include <list>
#include <string>

#include "absl/status/status.h"
#include "import/child.h"
#include "import/file_request.h"

namespace motiondb::importer {

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
