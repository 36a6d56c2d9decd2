// Options whose value is a list of numbers: "2,1,0.5". Pure functions.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace motiondb::client {

// The numbers between the commas; nothing unless all are finite numbers.
std::optional<std::vector<double>> ParseNumbers(const std::string& text);

// Checks an option's value: `fits` says whether the numbers are right, `expected` what they should
// be.
CLI::Validator NumberList(const char* expected, bool (*fits)(const std::vector<double>&));

}  // namespace motiondb::client
