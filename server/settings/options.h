// Kinds of options that settings share: numbers, durations, sizes and addresses.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <concepts>
#include <string>
#include <utility>
#include <vector>

namespace motiondb::server {

// Adds a duration in seconds, from `min` to `max`. `time` contains the default and must outlive
// `app`.
CLI::Option* AddSeconds(CLI::App& app, const std::string& name, std::chrono::milliseconds& time,
                        double min, double max, const std::string& description);

// Accepts text that is a whole number. For 2.5, CLI::Range alone reports a value out of range.
CLI::Validator WholeNumber();

// Adds a whole number from `min` to `max`. `count` contains the default and must outlive `app`.
template <std::integral Count>
CLI::Option* AddCount(CLI::App& app, const std::string& name, Count& count, int min, int max,
                      const std::string& description) {
  return app.add_option(name, count, description)
      ->type_name("N")
      ->check(WholeNumber())
      ->check(CLI::Range(min, max))
      ->capture_default_str();
}

// Adds a size in units of 2^kBits bytes, from `min` to `max`. `bytes` contains the default and must
// outlive `app`.
template <int kBits, std::integral Bytes>
CLI::Option* AddBytes(CLI::App& app, const std::string& name, Bytes& bytes, const std::string& unit,
                      const std::string& description, int max, int min = 1) {
  return app
      .add_option_function<int>(
          name, [&bytes](int units) { bytes = static_cast<Bytes>(units) << kBits; }, description)
      ->type_name(unit)
      ->check(WholeNumber())
      ->check(CLI::Range(min, max))
      ->default_str(std::to_string(bytes >> kBits));
}

// Adds a size in mebibytes.
template <std::integral Bytes>
CLI::Option* AddMebibytes(CLI::App& app, const std::string& name, Bytes& bytes,
                          const std::string& description, int max = 1024, int min = 1) {
  return AddBytes<20>(app, name, bytes, "MIB", description, max, min);
}

template <typename Value, std::size_t kCount>
using Words = std::array<std::pair<const char*, Value>, kCount>;

// Adds an option with a fixed set of words as values. The first word is the default.
template <typename Value, std::size_t kCount>
CLI::Option* AddWord(CLI::App& app, const std::string& name, Value& value,
                     const Words<Value, kCount>& words, const std::string& description) {
  std::vector<std::string> allowed;
  for (const auto& [word, meaning] : words) allowed.emplace_back(word);
  return app
      .add_option_function<std::string>(
          name,
          [&value, &words](const std::string& given) {
            for (const auto& [word, meaning] : words) {
              if (given == word) value = meaning;
            }
          },
          description)
      ->check(CLI::IsMember(allowed))
      ->default_str(allowed.front());
}

// Accepts HOST:PORT or [IPV6]:PORT with a port from 0 (any free port) to 65535.
CLI::Validator ListenAddress();

}  // namespace motiondb::server
