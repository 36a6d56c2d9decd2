// Kinds of options that settings share: values with a unit in the file, another in memory.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <concepts>
#include <string>

namespace motiondb::server {

// Given in seconds, from `least` to `most`. `time` holds the default and must outlive `app`.
CLI::Option* AddSeconds(CLI::App& app, const std::string& name, std::chrono::milliseconds& time,
                        double least, double most, const std::string& description);

// Of text that is a whole number. A range alone says of 2.5 that it is not in the range.
CLI::Validator WholeNumber();

// A whole number from `least` to `most`. `count` holds the default and must outlive `app`.
template <std::integral Count>
CLI::Option* AddCount(CLI::App& app, const std::string& name, Count& count, int least, int most,
                      const std::string& description) {
  return app.add_option(name, count, description)
      ->type_name("N")
      ->check(WholeNumber())
      ->check(CLI::Range(least, most))
      ->capture_default_str();
}

// Given in units of 2^kBits bytes, from `least` to `most`. `bytes` holds the default and must
// outlive `app`.
template <int kBits, std::integral Bytes>
CLI::Option* AddBytes(CLI::App& app, const std::string& name, Bytes& bytes, const std::string& unit,
                      const std::string& description, int most, int least = 1) {
  return app
      .add_option_function<int>(
          name, [&bytes](int units) { bytes = static_cast<Bytes>(units) << kBits; }, description)
      ->type_name(unit)
      ->check(WholeNumber())
      ->check(CLI::Range(least, most))
      ->default_str(std::to_string(bytes >> kBits));
}

// The same in mebibytes.
template <std::integral Bytes>
CLI::Option* AddMebibytes(CLI::App& app, const std::string& name, Bytes& bytes,
                          const std::string& description, int most = 1024, int least = 1) {
  return AddBytes<20>(app, name, bytes, "MIB", description, most, least);
}

// Of what is listened on: HOST:PORT, [IPV6]:PORT, port from 0 (a free one) to 65535.
CLI::Validator ListenAddress();

}  // namespace motiondb::server
