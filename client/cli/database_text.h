// Databases, clips and operations as tables for a person. Pure functions.
#pragma once

#include <google/protobuf/timestamp.pb.h>
#include <motiondb/messages.h>

#include <string>
#include <vector>

namespace motiondb::client {

std::string DatabasesText(const std::vector<v1::Database>& databases);

// One database and its settings, a line each.
std::string DatabaseText(const v1::Database& database);

std::string ClipsText(const std::vector<v1::Clip>& clips);

// One clip in one line, followed by what the reader found out about its file.
std::string IngestedClipText(const v1::Clip& clip);

// The figures of the paper's Table I, and those beside them.
std::string DescriptionText(const v1::DescribeDatabaseResponse& description);

std::string OperationsText(const std::vector<v1::Operation>& operations);

// "running", "succeeded", ...
std::string StateWord(const v1::Operation& operation);

// The last word of an enum's name, in small letters: SCALING_KIND -> "kind".
std::string LastWord(const std::string& enum_name);

// To the second: a person does not read nanoseconds.
std::string TimeText(const google::protobuf::Timestamp& time);

// What a label is called where it is empty.
std::string LabelWord(const std::string& label);

}  // namespace motiondb::client
