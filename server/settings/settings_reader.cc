#include "server/settings/settings_reader.h"

#include <fmt/format.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "core/motion/error.h"
#include "server/settings/groups.h"
#include "storage/store_url.h"

namespace motiondb::server {

namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 20;

// Returns the text of a string, number or boolean; nullopt for other types, which no setting has.
std::optional<std::string> TextOf(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* truth = node.as_boolean()) return fmt::format("{}", truth->get());
  return std::nullopt;
}

absl::StatusOr<std::vector<std::string>> ValuesOf(const toml::node& node) {
  std::vector<std::string> values;
  const auto add = [&](const toml::node& element) {
    std::optional<std::string> text = TextOf(element);
    if (!text) return false;
    values.push_back(*std::move(text));
    return true;
  };
  const toml::array* const array = node.as_array();
  if (array == nullptr ? add(node) : std::ranges::all_of(*array, add)) return values;
  if (node.is_table()) return core::InvalidArgument("expected `key = value`, got a table");
  return core::InvalidArgument("expected a string, a number, true or false, or an array of these");
}

// Returns whether TOML can have the value without quotes and parses it to the same text.
bool IsBare(const std::string& value) {
  try {
    const toml::table table = toml::parse("v = " + value);
    const toml::node* const node = table.get("v");
    return table.size() == 1 && node != nullptr && !node->is_string() && TextOf(*node) == value;
  } catch (const toml::parse_error&) {
    return false;
  }
}

std::string Quote(const std::string& value) {
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\t') {
      quoted += "\\t";
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

std::vector<FileSetting> ParseSettings(const std::string& name, const std::string& text,
                                       std::vector<absl::Status>& problems) {
  toml::table table;
  try {
    table = toml::parse(text);
  } catch (const toml::parse_error& error) {
    problems.push_back(core::InvalidArgument("{}:{}: {}", name, error.source().begin.line,
                                             std::string(error.description())));
    return {};
  }
  std::vector<FileSetting> settings;
  for (const auto& [key, node] : table) {
    const int line = static_cast<int>(key.source().begin.line);
    auto values = ValuesOf(node);
    if (values.ok()) {
      settings.push_back({line, std::string(key.str()), *std::move(values)});
    } else {
      problems.push_back(core::InvalidArgument("{}:{}: {}: {}", name, line, std::string(key.str()),
                                               std::string(values.status().message())));
    }
  }
  std::ranges::sort(settings, {}, &FileSetting::line);
  return settings;
}

absl::StatusOr<std::string> ReadSettingsFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(kMaxFileBytes + 1);
    errno = 0;
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad()) {
    return absl::ErrnoToStatus(errno, fmt::format("{}: cannot be read", path));
  }
  if (text.size() > kMaxFileBytes) {
    return core::InvalidArgument("{}: expected a file of at most 1 MiB", path);
  }
  return text;
}

std::string FormatValues(const std::vector<std::string>& values, bool is_array) {
  const auto format = [](const std::string& value) { return IsBare(value) ? value : Quote(value); };
  if (!is_array) return values.empty() ? "\"\"" : format(values.front());
  std::string array;
  for (const std::string& value : values) array += (array.empty() ? "" : ", ") + format(value);
  return "[" + array + "]";
}

namespace {

constexpr std::string_view kPrefix = "MOTIONDBD_";

std::string KeyOf(const CLI::Option& option) { return option.get_lnames().front(); }

// rebuild-delay -> MOTIONDBD_REBUILD_DELAY
std::string VariableOf(const std::string& key) {
  std::string name(kPrefix);
  for (const char c : key) {
    name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return name;
}

bool IsFlag(const CLI::Option& option) { return option.get_expected_min() == 0; }
// Returns the value of a flag in a file or variable as "true" or "false"; empty for other text.
// CLI11 reads an empty variable as true, which would be a trap.
std::string TruthOf(std::string value) {
  value = CLI::detail::to_lower(value);
  if (value == "true" || value == "1" || value == "yes" || value == "on") return "true";
  if (value == "false" || value == "0" || value == "no" || value == "off") return "false";
  return "";
}
bool IsArray(const CLI::Option& option) { return option.get_expected_max() > 1; }

std::vector<std::string> DefaultOf(const CLI::Option& option) {
  if (IsFlag(option)) return {"false"};
  std::string text = option.get_default_str();
  if (!IsArray(option)) return {text};
  std::erase_if(text, [](char c) { return c == '[' || c == ']'; });
  return text.empty() ? std::vector<std::string>() : CLI::detail::split(text, ',');
}

// Removed settings and their replacements. A file with a removed setting still works.
constexpr std::pair<const char*, const char*> kRemoved[] = {
    {"heavy-threads", "long work uses all threads but one (see threads)"},
    {"rebuild-delay-limit", "the limit is 10 s, or rebuild-delay if that is more"},
    {"max-metadata-kib", "the limit is 8 KiB of metadata for each call"},
    {"max-calls-per-client", "the limit is a quarter of max-calls"},
    {"max-heavy-calls-per-client", "the limit is a quarter of max-heavy-calls"},
    {"max-streams", "the limit is a quarter of max-calls"},
    {"max-streams-per-client", "the limit is a quarter of the limit of all streams"},
    {"reflection", "reflection is on if authentication is off"},
};

const char* ReplacementOf(const std::string& key) {
  for (const auto& [removed, replacement] : kRemoved) {
    if (key == removed) return replacement;
  }
  return nullptr;
}

}  // namespace

Environment ReadEnvironment() {
  Environment environment;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text(*variable);
    const std::size_t equals = text.find('=');
    if (!text.starts_with(kPrefix) || equals == std::string_view::npos) continue;
    environment.emplace(text.substr(0, equals), text.substr(equals + 1));
  }
  return environment;
}

SettingsReader::SettingsReader()
    : app_("motiondbd: a database server for human motion", "motiondbd") {
  app_.get_help_ptr()->description("Print this help and exit")->configurable(false);
  app_.set_version_flag("--version", "motiondbd " MOTIONDB_VERSION, "Print the version and exit")
      ->configurable(false);
  app_.add_option("--config", file_,
                  "Configuration file with lines like listen = \"127.0.0.1:50051\"; or set "
                  "MOTIONDBD_CONFIG")
      ->type_name("FILE")
      ->configurable(false);
  app_.add_flag_callback(
          "--check-config", [this] { task_ = Task::kCheck; },
          "Check all settings and their files, print the settings, and exit; does not open the "
          "store")
      ->configurable(false);
  for (const auto& [key, replacement] : kRemoved) {  // hidden in the help
    app_.add_option("--" + std::string(key), removed_)->configurable(false)->group("");
  }
  AddStoreSettings(app_, settings_);
  AddNetworkSettings(app_, settings_);
  AddHttpSettings(app_, settings_);
  AddEngineSettings(app_, settings_);
  AddLimitSettings(app_, settings_);
  AddSecuritySettings(app_, settings_);
  AddLogSettings(app_, settings_);
  app_.footer(
      "Every setting is also a variable and a line of the configuration file: --rebuild-delay,\n"
      "MOTIONDBD_REBUILD_DELAY, rebuild-delay = 0.3. Flags override variables, and variables\n"
      "override the file.\n"
      "\n"
      "`motiondbd migrate FROM TO` copies a store: `motiondbd migrate --help`.");
}

std::vector<absl::Status> SettingsReader::CheckForStart() const {
  std::vector<absl::Status> problems;
  CheckHttpSettings(settings_, problems);
  CheckEngineSettings(settings_, problems);
  CheckLimitSettings(settings_, problems);
  CheckSecuritySettings(settings_, problems);
  return problems;
}

std::vector<absl::Status> SettingsReader::Check() const {
  std::vector<absl::Status> problems = CheckForStart();
  CheckStoreSettings(settings_, problems);
  return problems;
}

std::vector<absl::Status> SettingsReader::Read(int argc, const char* const* argv,
                                               const Environment& environment) {
  // The first pass reads --help and --config. The second pass, below, lets flags override.
  if (const absl::Status status = ParseFlags(argc, argv); !status.ok()) return {status};
  if (task_ == Task::kHelp || task_ == Task::kVersion) return {};
  const auto file = environment.find(VariableOf("config"));
  if (file_.empty() && file != environment.end()) file_ = file->second;

  std::vector<absl::Status> problems;
  if (!file_.empty()) ApplyFile(problems);
  ApplyEnvironment(environment, problems);
  if (const absl::Status status = ParseFlags(argc, argv); !status.ok()) problems.push_back(status);
  for (const CLI::Option* const option : Options()) {
    if (option->count() > 0) origins_[option] = {"--" + KeyOf(*option), option->results()};
  }
  for (const auto& [key, replacement] : kRemoved) {
    const std::string flag = "--" + std::string(key);
    if (app_.count(flag) > 0) WarnOfRemoved(flag, key);
  }
  EngineOptions& engine = settings_.server.engine;
  engine.rebuild_delay_limit = std::max(engine.rebuild_delay_limit, engine.rebuild_delay);
  if (settings_.store_path.empty()) {
    problems.push_back(absl::InvalidArgumentError(
        "store: not set; use --store FILE, MOTIONDBD_STORE or the line `store = \"FILE\"`"));
  }
  return problems;
}

absl::Status SettingsReader::ParseFlags(int argc, const char* const* argv) {
  try {
    app_.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    task_ = Task::kHelp;
  } catch (const CLI::CallForVersion&) {
    task_ = Task::kVersion;
  } catch (const CLI::Error& error) {
    return core::InvalidArgument("{}", error.what());
  }
  return absl::OkStatus();
}

std::vector<const CLI::Option*> SettingsReader::Options() const {
  return app_.get_options([](const CLI::Option* option) { return option->get_configurable(); });
}

absl::Status SettingsReader::Apply(const std::string& place, const std::string& key,
                                   std::vector<std::string> values) {
  if (ReplacementOf(key) != nullptr) {
    WarnOfRemoved(place, key);
    return absl::OkStatus();
  }
  CLI::Option* const found = app_.get_option_no_throw("--" + key);
  if (found == nullptr || !found->get_configurable()) {
    return core::InvalidArgument("{}: unknown setting: {}", place, key);
  }
  CLI::Option& option = *found;
  if (values.empty() || (values.size() > 1 && !IsArray(option))) {
    return core::InvalidArgument("{}: {}: expected one value", place, key);
  }
  if (IsFlag(option)) {
    values = {TruthOf(values.front())};
    if (values.front().empty()) {
      return core::InvalidArgument("{}: {}: expected true or false", place, key);
    }
  }
  try {
    option.clear();
    for (const std::string& value : values) option.add_result(value);
    option.run_callback();
  } catch (const CLI::Error& error) {
    return core::InvalidArgument("{}: {}", place, error.what());
  }
  origins_[&option] = {place, std::move(values)};
  return absl::OkStatus();
}

void SettingsReader::WarnOfRemoved(const std::string& place, const std::string& key) {
  warnings_.push_back(
      fmt::format("{}: {} was removed and is ignored: {}", place, key, ReplacementOf(key)));
}

void SettingsReader::ApplyFile(std::vector<absl::Status>& problems) {
  const absl::StatusOr<std::string> text = ReadSettingsFile(file_);
  if (!text.ok()) {
    problems.push_back(text.status());
    return;
  }
  for (const FileSetting& setting : ParseSettings(file_, *text, problems)) {
    const std::string place = fmt::format("{}:{}", file_, setting.line);
    const absl::Status status = Apply(place, setting.key, setting.values);
    if (!status.ok()) problems.push_back(status);
  }
}

void SettingsReader::ApplyEnvironment(const Environment& environment,
                                      std::vector<absl::Status>& problems) {
  Environment unknown = environment;
  unknown.erase(VariableOf("config"));
  for (const CLI::Option* const option : Options()) {
    const std::string variable = VariableOf(KeyOf(*option));
    const auto found = unknown.find(variable);
    if (found == unknown.end()) continue;
    const std::vector<std::string> values = IsArray(*option)
                                                ? CLI::detail::split(found->second, ',')
                                                : std::vector<std::string>{found->second};
    const absl::Status status = Apply(variable, KeyOf(*option), values);
    if (!status.ok()) problems.push_back(status);
    unknown.erase(found);
  }
  for (const auto& [key, replacement] : kRemoved) {
    if (unknown.erase(VariableOf(key)) > 0) WarnOfRemoved(VariableOf(key), key);
  }
  for (const auto& [variable, value] : unknown) {
    problems.push_back(core::InvalidArgument("{}: unknown setting", variable));
  }
}

std::vector<EffectiveSetting> SettingsReader::Effective() const {
  std::vector<EffectiveSetting> effective;
  for (const CLI::Option* const option : Options()) {
    const auto found = origins_.find(option);
    const Origin origin =
        found != origins_.end() ? found->second : Origin{"default", DefaultOf(*option)};
    std::vector<std::string> values = origin.values;
    std::ranges::transform(values, values.begin(), storage::WithoutPassword);
    effective.push_back({KeyOf(*option), FormatValues(values, IsArray(*option)), origin.source});
  }
  return effective;
}

}  // namespace motiondb::server
