// Databases, clips and operations as tables for a person. Pure functions.
#pragma once

#include <google/protobuf/timestamp.pb.h>
#include <motiondb/messages.h>

#include <cstdint>
#include <string>
#include <vector>

namespace motiondb::v1 {
enum Calibration : int;
}  // namespace motiondb::v1

namespace motiondb::client {

std::string DatabasesText(const std::vector<v1::Database>& databases);

// One database and its settings, a line each.
std::string DatabaseText(const v1::Database& database);

std::string ClipsText(const std::vector<v1::Clip>& clips);

// One clip in one line, followed by what the reader found out about its file.
std::string IngestedClipText(const v1::Clip& clip);

// A line for a model that has no calibration of its own yet; else empty.
std::string BorrowedCalibrationText(v1::Calibration calibration);

// The figures of the paper's Table I, and those beside them.
std::string DescriptionText(const v1::DatabaseStatistics& description);

// The clips that could not be derived again, a line each; empty where there is none.
std::string UnderivedText(const v1::DatabaseStatistics& description);

std::string OperationsText(const std::vector<v1::Operation>& operations);

// "running", "succeeded", ...
std::string StateWord(const v1::Operation& operation);

// The last word of an enum's name, in small letters: SCALING_KIND -> "kind".
std::string LastWord(const std::string& enum_name);

// To the second: a person does not read nanoseconds.
std::string TimeText(const google::protobuf::Timestamp& time);

// What a label is called where it is empty.
std::string LabelWord(const std::string& label);

// Tokens and the record of changes as tables for a person. Pure functions.

// `now_seconds` since the Unix epoch tells which tokens have expired.
std::string TokensText(const std::vector<v1::Token>& tokens, std::int64_t now_seconds);

// One token in one line: whom it is good for, and how long.
std::string TokenText(const v1::Token& token);

std::string AuditText(const v1::ListAuditEntriesResponse& response);

// How a server is doing, on one screen for a person. Pure functions.

// `now_us`: the time it is now, in microseconds since the Unix epoch.
std::string StatusText(const v1::GetServerStatusResponse& status, std::int64_t now_us);

// In its two largest units: "12 s", "3 min 4 s", "5 h 0 min", "2 d 7 h".
std::string DurationText(std::int64_t seconds);

// Three figures in a unit that suits: "0.42 ms", "12.5 ms", "3.20 s", "75.0 s".
std::string LatencyText(double seconds);

// In the largest unit that leaves at least 1: "512 B", "1.5 MiB".
std::string BytesText(std::int64_t bytes);

}  // namespace motiondb::client
