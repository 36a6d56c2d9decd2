#include "client/cli/usage/completion.h"

#include <algorithm>

#include "absl/strings/str_split.h"
#include "client/cli/usage/server_names.h"

namespace motiondb::client {
namespace {

// Where the last word is.
struct Cursor {
  const CLI::App* command = nullptr;
  const CLI::Option* option = nullptr;  // whose value it is; null: none or not known
  std::string database;                 // given before
};

const CLI::Option* FindOption(const CLI::App& command, const std::string& name) {
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent()) {
    if (const CLI::Option* option = app->get_option_no_throw(name)) return option;
  }
  return nullptr;
}

// Bash splits "--layer=3" into three words.
std::vector<std::string> WithoutEquals(const std::vector<std::string>& words) {
  std::vector<std::string> result;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool is_equals = words[i] == "=" && i > 0 && words[i - 1].starts_with("--");
    if (!is_equals) result.push_back(words[i]);
    if (is_equals && i + 1 == words.size()) result.emplace_back();
  }
  return result;
}

Cursor FindCursor(const CLI::App& program, const std::vector<std::string>& words) {
  Cursor cursor{&program, nullptr, ""};
  std::vector<const CLI::Option*> arguments;
  const auto use_command = [&](const CLI::App& command) {
    cursor.command = &command;
    arguments =
        command.get_options([](const CLI::Option* option) { return option->get_positional(); });
  };
  use_command(program);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool is_last = i + 1 == words.size();
    const std::string& word = words[i];
    if (cursor.option != nullptr) {  // its value
      if (is_last) break;
      if (KindOf(*cursor.option) == NameKind::kDatabase) cursor.database = word;
      cursor.option = nullptr;
    } else if (word.starts_with('-')) {
      const CLI::Option* const option = FindOption(*cursor.command, word);
      const bool takes_value = option != nullptr && option->get_items_expected_max() > 0;
      if (takes_value && !is_last) cursor.option = option;
    } else if (const CLI::App* inner = FindCommand(*cursor.command, word);
               inner != nullptr && !is_last) {
      use_command(*inner);
    } else if (!arguments.empty()) {
      if (is_last) {
        cursor.option = arguments.front();
        break;
      }
      if (KindOf(*arguments.front()) == NameKind::kDatabase) cursor.database = word;
      const bool repeats = arguments.front()->get_items_expected_max() > 1;
      if (!repeats) arguments.erase(arguments.begin());
    }
  }
  return cursor;
}

std::vector<Candidate> OptionCandidates(const CLI::App& command) {
  std::vector<Candidate> candidates;
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent()) {
    for (const CLI::Option* option : app->get_options()) {
      // The program's --help is that of the command.
      const bool is_hidden =
          app != &command && (option->check_lname("help") || option->check_lname("version"));
      for (const std::string& name : option->get_lnames()) {
        if (!is_hidden) candidates.push_back({"--" + name, option->get_description()});
      }
    }
  }
  return candidates;
}

// Returns the words of "METHOD:{best,paper}".
std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return absl::StrSplit(type.substr(begin + 1, end - begin - 1), ',');
}

std::vector<Candidate> ValueCandidates(const Cursor& cursor, const GlobalOptions& global) {
  std::vector<std::string> words = ChoicesOf(*cursor.option);
  const NameKind kind = KindOf(*cursor.option);
  const bool is_new = cursor.command->get_name() == "create" && kind == NameKind::kDatabase &&
                      cursor.option->get_positional();
  if (kind != NameKind::kNone && !is_new) {
    GlobalOptions quick = global;
    // A shell waits.
    quick.connect_timeout = std::chrono::milliseconds(300);
    quick.timeout_seconds = 2;
    if (const auto client = Connect(quick); client.ok()) {
      words = NamesInServer(*client, kind, cursor.database);
    }
  }
  const bool has_time = cursor.option->get_type_name().starts_with("CLIP@");
  std::vector<Candidate> candidates;
  candidates.reserve(words.size());
  for (const std::string& word : words) candidates.push_back({word + (has_time ? "@" : ""), ""});
  return candidates;
}

}  // namespace

std::vector<Candidate> Complete(const CLI::App& program, const GlobalOptions& global,
                                std::vector<std::string> words) {
  words = WithoutEquals(words);
  if (words.empty()) words.emplace_back();
  const Cursor cursor = FindCursor(program, words);
  const std::string& last = words.back();
  std::vector<Candidate> candidates;
  const bool is_command_expected = cursor.command->get_name() == "help" || cursor.option == nullptr;
  if (last.starts_with('-')) {
    candidates = OptionCandidates(*cursor.command);
  } else if (is_command_expected) {
    const CLI::App& parent = cursor.command->get_name() == "help" ? program : *cursor.command;
    for (const CLI::App* inner : parent.get_subcommands({})) {
      candidates.push_back({inner->get_name(), inner->get_description()});
    }
  } else {
    candidates = ValueCandidates(cursor, global);
  }
  std::erase_if(candidates, [&](const Candidate& each) { return !each.word.starts_with(last); });
  return candidates;
}

}  // namespace motiondb::client
