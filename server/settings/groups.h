// The groups of settings, and the kinds of options that they share. The `Add` function of a group
// declares each setting once, as a CLI11 option with default, check and description. This
// declaration defines the flag `--rebuild-delay`, the variable `MOTIONDBD_REBUILD_DELAY`, the key
// `rebuild-delay` of the file, the manual page and the output of --check-config.
//
// To add a group: add a line here, a line in settings_reader.cc, its functions, and its settings in
// deploy/motiondbd.conf (a test compares them).
//
// Put a check of a single value (range, existing file, address) into the option: its error names
// the file and line of the value. Put a check of several settings or of the machine into the
// group's `Check`. --check-config and a start call it; a start does not call CheckStoreSettings,
// because it then opens the store.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <concepts>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/settings/settings.h"

namespace motiondb::server {

// `settings` must outlive `app`. Mark an option that is not a setting with `configurable(false)`.
void AddStoreSettings(CLI::App& app, Settings& settings);
void AddNetworkSettings(CLI::App& app, Settings& settings);
void AddHttpSettings(CLI::App& app, Settings& settings);
void AddEngineSettings(CLI::App& app, Settings& settings);
void AddLimitSettings(CLI::App& app, Settings& settings);
void AddSecuritySettings(CLI::App& app, Settings& settings);
void AddLogSettings(CLI::App& app, Settings& settings);

// Append the problems of the settings as a whole. Open and change no files.
void CheckStoreSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckHttpSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckEngineSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckLimitSettings(const Settings& settings, std::vector<absl::Status>& problems);
void CheckSecuritySettings(const Settings& settings, std::vector<absl::Status>& problems);

// Kinds of options that settings share: numbers, durations, sizes and addresses.

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
