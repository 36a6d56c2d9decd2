// Answers one request, to read or to convert a file, in a child process.
#pragma once

#include <cstdio>
#include <string_view>

#include "absl/status/status.h"
#include "import/file_request.h"

namespace motiondb::importer {

// kRead: the motion (storage/blob/motion_codec.h). kConvert: a file in another format.
enum class SingleFileTask { kRead, kConvert };

// Writes the answer to `output`: a JSON object in one line, then `bytes` bytes of content. Fields:
//   bytes                          size of the content; the only field of kRead
//   report, points, frame_count,
//   frame_rate_hz, losses          of kConvert
//   error, code, reason, takes,
//   take_count                     instead of the others: code of absl::StatusCode
// UNAVAILABLE if no child process or sandbox can be made, or if the output cannot be written.
absl::Status AnswerSingleFile(SingleFileTask task, std::string_view request_line,
                              const FileLimits& limits, std::FILE* output);

}  // namespace motiondb::importer
