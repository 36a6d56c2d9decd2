// Databases and clips as text for the terminal.
#pragma once

#include <google/protobuf/timestamp.pb.h>
#include <motiondb/messages.h>

#include <string>
#include <vector>

#include "client/cli/terminal/table.h"

namespace motiondb::v1 {
enum Calibration : int;
}  // namespace motiondb::v1

namespace motiondb::client {

Table DatabasesTable(const std::vector<v1::Database>& databases);

// Returns a database and its settings, one per line.
std::string DatabaseText(const v1::Database& database);

Table ClipsTable(const std::vector<v1::Clip>& clips);

// Returns why clips could not be derived again, one per line after a heading; empty if there are
// none.
std::string UnderivedText(const std::vector<v1::Clip>& clips);

// Returns a line for the clip, then the indented report of the file reader.
std::string IngestedClipText(const v1::Clip& clip);

// Returns a note if the model has no calibration of its own yet; else an empty string.
std::string CalibrationNote(v1::Calibration calibration);

// Returns why the model's own calibration has no probability of unknown motion, and what to do;
// else an empty string.
std::string UnknownNote(v1::Calibration calibration);

// Returns statistics of the model, with those of the paper's Table I.
std::string DescriptionText(const v1::DatabaseStatistics& description);

// Returns the clips that could not be derived again, one per line; empty if there are none.
std::string UnderivedText(const v1::DatabaseStatistics& description);

// Returns the last word of an enum name in lower case: SCALING_KIND -> "kind".
std::string EnumValueText(const std::string& enum_name);

// Returns the time without fractions of seconds.
std::string TimeText(const google::protobuf::Timestamp& time);

// Returns the label, or "(no label)" if it is empty.
std::string LabelOrPlaceholder(const std::string& label);

}  // namespace motiondb::client
