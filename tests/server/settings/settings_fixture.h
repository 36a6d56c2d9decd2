// Reads settings as motiondbd does, from arguments, variables and a configuration file.
#pragma once

#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "server/settings/settings_reader.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {

// Reads the arguments of motiondbd, without its name, and returns the messages of all problems.
inline std::vector<std::string> ReadSettings(server::SettingsReader& reader,
                                             std::vector<std::string> arguments,
                                             const server::Environment& environment = {}) {
  arguments.insert(arguments.begin(), "motiondbd");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::vector<std::string> messages;
  for (const absl::Status& problem :
       reader.Read(static_cast<int>(argv.size()), argv.data(), environment)) {
    messages.emplace_back(problem.message());
  }
  return messages;
}

// FAILs if there is no setting `key`.
inline server::EffectiveSetting FindSetting(const server::SettingsReader& reader,
                                            const std::string& key) {
  for (const server::EffectiveSetting& setting : reader.Effective()) {
    if (setting.key == key) return setting;
  }
  FAIL("no setting " + key);
  return {};
}

// Writes the configuration file motiondbd.conf and returns its path.
inline std::string WriteConfig(const TemporaryDirectory& directory, const std::string& text) {
  std::ofstream(directory / "motiondbd.conf") << text;
  return directory / "motiondbd.conf";
}

}  // namespace motiondb::tests
