#include "core/format/marker_set_file.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {
namespace {

constexpr std::string_view kMagic = "motiondb-marker-set";
constexpr std::string_view kVersion = "1";

struct Token {
  std::string text;
  bool quoted = false;  // a quoted token is always a name
};

// Splits a line at blanks. "..." quotes a name with blanks; "" inside it is a quote; # starts a
// comment.
absl::StatusOr<std::vector<Token>> Tokens(std::string_view line) {
  std::vector<Token> tokens;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == ' ' || line[i] == '\t') {
      ++i;
    } else if (line[i] == '#') {
      break;
    } else if (line[i] == '"') {
      Token name{.quoted = true};
      for (bool open = true; open;) {
        const std::size_t end = line.find('"', ++i);
        if (end == std::string_view::npos) return InvalidArgument("expected a closing quote");
        name.text += line.substr(i, end - i);
        i = end + 1;
        open = line.substr(i).starts_with('"');  // "" is a quote in the name
        if (open) name.text += '"';
      }
      tokens.push_back(std::move(name));
    } else {
      const std::size_t end = std::min(line.find_first_of(" \t#", i), line.size());
      tokens.push_back({std::string(line.substr(i, end - i)), false});
      i = end;
    }
  }
  return tokens;
}

// Removes the first line, with its end, from `text` and returns it without its end.
std::string_view NextLine(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  const bool crlf = text.substr(end).starts_with("\r\n");
  text.remove_prefix(std::min(text.size(), end + (crlf ? 2 : 1)));
  return line;
}

std::optional<double> Number(const Token& token) {
  double value = 0;
  const char* end = token.text.data() + token.text.size();
  const auto parsed = std::from_chars(token.text.data(), end, value);
  if (token.quoted || parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

class Reader {
 public:
  absl::Status ReadLine(const std::vector<Token>& tokens) {
    if (!started_) {
      if (tokens.size() != 2 || tokens[0].text != kMagic || tokens[1].text != kVersion) {
        return InvalidArgument("expected '{} {}' first", kMagic, kVersion);
      }
      started_ = true;
      return absl::OkStatus();
    }
    const std::string& word = tokens[0].text;
    if (tokens.size() >= 2 && tokens[1].text == "=" && !tokens[1].quoted) return ReadRule(tokens);
    if (word == "name") return ReadName(tokens);
    if (word == "extend") return ReadExtend(tokens);
    if (word == "marker") return ReadMarker(tokens);
    if (word == "hips") return ReadHips(tokens);
    if (word == "leg") return ReadLeg(tokens);
    if (word == "mapping") return ReadMapping(tokens);
    if (word == "signature") return ReadSignature(tokens);
    return InvalidArgument(
        "expected name, extend, marker, hips, leg, mapping, signature or MARKER = ..., got '{}'",
        word);
  }

  absl::StatusOr<MarkerScheme> Finish() {
    if (!started_) return InvalidArgument("expected '{} {}' first", kMagic, kVersion);
    if (scheme_.set.name.empty()) return InvalidArgument("expected a line 'name NAME'");
    if (scheme_.set.markers.empty()) return InvalidArgument("expected at least one 'marker NAME'");
    MOTIONDB_RETURN_IF_ERROR(FinishMapping());
    // The first of equal mappings wins, so that a file can replace a mapping of its base.
    scheme_.mappings.insert(scheme_.mappings.end(), base_mappings_.begin(), base_mappings_.end());
    if (scheme_.set.landmarks.left_hip < 0) {
      scheme_.set.landmarks = RecognizeLandmarks(scheme_.set.markers);
    }
    if (scheme_.set.landmarks.left_hip < 0 || scheme_.set.landmarks.right_hip < 0) {
      return InvalidArgument("expected a line 'hips LEFT RIGHT': no hips among the marker names");
    }
    return std::move(scheme_);
  }

 private:
  static absl::Status Expect(const std::vector<Token>& tokens, std::size_t count,
                             std::string_view form) {
    if (tokens.size() == count) return absl::OkStatus();
    return InvalidArgument("expected '{}'", form);
  }

  absl::StatusOr<int> Marker(const std::string& name) const {
    for (std::size_t m = 0; m < scheme_.set.markers.size(); ++m) {
      if (scheme_.set.markers[m] == name) return static_cast<int>(m);
    }
    return InvalidArgument("expected a marker of the set, got '{}'", name);
  }

  absl::Status ReadName(const std::vector<Token>& tokens) {
    MOTIONDB_RETURN_IF_ERROR(Expect(tokens, 2, "name NAME"));
    scheme_.set.name = tokens[1].text;
    return absl::OkStatus();
  }

  absl::Status ReadExtend(const std::vector<Token>& tokens) {
    const MarkerScheme& base = StandardScheme();
    if (tokens.size() != 2 || tokens[1].text != base.set.name) {
      return InvalidArgument("expected 'extend {}'", base.set.name);
    }
    if (!scheme_.set.name.empty() || !scheme_.set.markers.empty()) {
      return InvalidArgument("expected 'extend {}' instead of a name and markers", base.set.name);
    }
    std::string_view rest = Standard34Set();
    for (NextLine(rest); !rest.empty();) {  // without the first line
      MOTIONDB_ASSIGN_OR_RETURN(const auto line, Tokens(NextLine(rest)));
      if (!line.empty()) MOTIONDB_RETURN_IF_ERROR(ReadLine(line));
    }
    base_mappings_ = base.mappings;
    return absl::OkStatus();
  }

  absl::Status ReadMarker(const std::vector<Token>& tokens) {
    MOTIONDB_RETURN_IF_ERROR(Expect(tokens, 2, "marker NAME"));
    if (tokens[1].text.empty()) return InvalidArgument("expected a marker name that is not empty");
    if (Marker(tokens[1].text).ok()) {
      return InvalidArgument("expected unique markers, got '{}' twice", tokens[1].text);
    }
    if (mapping_) return InvalidArgument("expected all markers before the first mapping");
    if (scheme_.set.markers.size() == kMaxMarkers) {
      return InvalidArgument("expected at most {} markers", kMaxMarkers);
    }
    scheme_.set.markers.push_back(tokens[1].text);
    return absl::OkStatus();
  }

  absl::Status ReadHips(const std::vector<Token>& tokens) {
    MOTIONDB_RETURN_IF_ERROR(Expect(tokens, 3, "hips LEFT RIGHT"));
    MOTIONDB_ASSIGN_OR_RETURN(scheme_.set.landmarks.left_hip, Marker(tokens[1].text));
    MOTIONDB_ASSIGN_OR_RETURN(scheme_.set.landmarks.right_hip, Marker(tokens[2].text));
    if (scheme_.set.landmarks.left_hip == scheme_.set.landmarks.right_hip) {
      return InvalidArgument("expected left and right hip to be two markers");
    }
    return absl::OkStatus();
  }

  absl::Status ReadLeg(const std::vector<Token>& tokens) {
    MOTIONDB_RETURN_IF_ERROR(Expect(tokens, 4, "leg HIP KNEE ANKLE"));
    if (scheme_.set.landmarks.legs.size() == 2) return InvalidArgument("expected at most two legs");
    std::array<int, 3> leg;
    for (int i = 0; i < 3; ++i) {
      MOTIONDB_ASSIGN_OR_RETURN(leg[i], Marker(tokens[i + 1].text));
    }
    scheme_.set.landmarks.legs.push_back(leg);
    return absl::OkStatus();
  }

  absl::Status ReadMapping(const std::vector<Token>& tokens) {
    MOTIONDB_RETURN_IF_ERROR(Expect(tokens, 2, "mapping NAME"));
    MOTIONDB_RETURN_IF_ERROR(FinishMapping());
    if (scheme_.mappings.size() == kMaxMappings) {
      return InvalidArgument("expected at most {} mappings", kMaxMappings);
    }
    mapping_ = MarkerMapping{tokens[1].text, {}, {}};
    mapping_->rules.resize(scheme_.set.markers.size());
    return absl::OkStatus();
  }

  absl::Status ReadSignature(const std::vector<Token>& tokens) {
    if (!mapping_) return InvalidArgument("expected 'mapping NAME' before its signature");
    for (std::size_t i = 1; i < tokens.size(); ++i) mapping_->signature.push_back(tokens[i].text);
    return absl::OkStatus();
  }

  // OK if the rule can have one more point.
  static absl::Status CheckPointCount(const MarkerRule& rule, std::string_view marker) {
    if (rule.points.size() < kMaxRulePoints) return absl::OkStatus();
    return InvalidArgument("marker '{}' is made of more than {} points", marker, kMaxRulePoints);
  }

  // MARKER = [WEIGHT] POINT [+ [WEIGHT] POINT]... [offset JOINT X Y Z]
  absl::Status ReadRule(const std::vector<Token>& tokens) {
    MOTIONDB_ASSIGN_OR_RETURN(const int marker, Marker(tokens[0].text));
    if (!mapping_) defaults_.resize(scheme_.set.markers.size());
    MarkerRule& rule = mapping_ ? mapping_->rules[marker] : defaults_[marker];
    if (!rule.points.empty()) {
      return InvalidArgument("expected one rule for marker '{}', got a second", tokens[0].text);
    }
    const auto plain = [&](std::size_t i, std::string_view word) {
      return i < tokens.size() && !tokens[i].quoted && tokens[i].text == word;
    };
    double sum = 0;
    std::size_t at = 1;  // at '=' or '+'
    do {
      ++at;
      WeightedPoint point;
      const auto weight = at < tokens.size() ? Number(tokens[at]) : std::nullopt;
      if (weight) ++at;
      if (at >= tokens.size() || plain(at, "+") || plain(at, "offset")) {
        return InvalidArgument("expected the name of a joint or marker{}",
                               weight ? " after the weight" : "");
      }
      MOTIONDB_RETURN_IF_ERROR(CheckPointCount(rule, tokens[0].text));
      rule.points.push_back({tokens[at].text, weight.value_or(1)});
      sum += rule.points.back().weight;
      ++at;
    } while (plain(at, "+"));
    if (std::abs(sum - 1) > 1e-6) {
      return InvalidArgument("expected weights that sum to 1, got {}", sum);
    }
    if (at == tokens.size()) return absl::OkStatus();
    if (!mapping_) return InvalidArgument("expected no offset in a rule before the first mapping");
    if (!plain(at, "offset") || tokens.size() != at + 5) {
      return InvalidArgument("expected '+ POINT', 'offset JOINT X Y Z' or the line's end at '{}'",
                             tokens[at].text);
    }
    rule.offset_joint = tokens[at + 1].text;
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = Number(tokens[at + 2 + axis]);
      if (!value) return InvalidArgument("expected a number, got '{}'", tokens[at + 2 + axis].text);
      rule.offset[axis] = *value;
    }
    return absl::OkStatus();
  }

  // Expands a default rule with the mapping's rules for the markers that it uses.
  absl::StatusOr<MarkerRule> ExpandDefault(const std::vector<MarkerRule>& given,
                                           std::size_t marker) const {
    MarkerRule expanded;
    for (const WeightedPoint& part : defaults_[marker].points) {
      const auto source = Marker(part.name);
      if (!source.ok() || given[*source].points.empty() || !given[*source].offset_joint.empty()) {
        return InvalidArgument(
            "mapping '{}': expected a rule without an offset for marker '{}', which '{}' is made "
            "of",
            mapping_->name, part.name, scheme_.set.markers[marker]);
      }
      for (const WeightedPoint& point : given[*source].points) {
        MOTIONDB_RETURN_IF_ERROR(CheckPointCount(expanded, scheme_.set.markers[marker]));
        expanded.points.push_back({point.name, part.weight * point.weight});
      }
    }
    if (!expanded.points.empty()) return expanded;
    return InvalidArgument("mapping '{}' has no rule for marker '{}'", mapping_->name,
                           scheme_.set.markers[marker]);
  }

  absl::Status FinishMapping() {
    if (!mapping_) return absl::OkStatus();
    defaults_.resize(scheme_.set.markers.size());
    const std::vector<MarkerRule> given = mapping_->rules;
    std::set<std::string> signature(mapping_->signature.begin(), mapping_->signature.end());
    for (std::size_t m = 0; m < mapping_->rules.size(); ++m) {
      if (given[m].points.empty()) {
        MOTIONDB_ASSIGN_OR_RETURN(mapping_->rules[m], ExpandDefault(given, m));
      }
      if (!mapping_->signature.empty()) continue;
      for (const WeightedPoint& point : mapping_->rules[m].points) signature.insert(point.name);
    }
    // A mapping without a signature line fits every motion that has all points it uses.
    mapping_->signature.assign(signature.begin(), signature.end());
    scheme_.mappings.push_back(std::move(*mapping_));
    mapping_.reset();
    return absl::OkStatus();
  }

  bool started_ = false;
  MarkerScheme scheme_;
  std::vector<MarkerRule> defaults_;  // rules before the first mapping, in terms of markers
  std::optional<MarkerMapping> mapping_;
  std::vector<MarkerMapping> base_mappings_;  // of the extended set
};

std::string Quoted(const std::string& name) {
  const bool plain = !name.empty() && name.find_first_of(" \t#\"=+") == std::string::npos &&
                     !Number({name, false}) && name != "offset";
  if (plain) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

absl::StatusOr<MarkerScheme> ReadMarkerSetFile(SourceFile file) {
  Reader reader;
  int number = 0;
  for (std::string_view rest = file.bytes; !rest.empty();) {
    ++number;
    auto tokens = Tokens(NextLine(rest));
    absl::Status status = tokens.status();
    if (tokens.ok() && !tokens->empty()) status = reader.ReadLine(*tokens);
    if (!status.ok())
      return InvalidArgument("{}:{}: {}", file.name, number, std::string(status.message()));
  }
  auto scheme = reader.Finish();
  if (!scheme.ok()) {
    return InvalidArgument("{}: {}", file.name, std::string(scheme.status().message()));
  }
  return scheme;
}

std::string WriteMarkerSetFile(const MarkerScheme& scheme) {
  const MarkerSet& set = scheme.set;
  std::string text = fmt::format("{} {}\nname {}\n", kMagic, kVersion, Quoted(set.name));
  for (const std::string& marker : set.markers) text += fmt::format("marker {}\n", Quoted(marker));
  const auto name = [&](int marker) { return Quoted(set.markers[marker]); };
  text += fmt::format("hips {} {}\n", name(set.landmarks.left_hip), name(set.landmarks.right_hip));
  for (const auto& leg : set.landmarks.legs) {
    text += fmt::format("leg {} {} {}\n", name(leg[0]), name(leg[1]), name(leg[2]));
  }
  for (const MarkerMapping& mapping : scheme.mappings) {
    text += fmt::format("mapping {}\nsignature", Quoted(mapping.name));
    for (const std::string& point : mapping.signature) text += ' ' + Quoted(point);
    text += '\n';
    for (std::size_t m = 0; m < mapping.rules.size(); ++m) {
      const MarkerRule& rule = mapping.rules[m];
      text += fmt::format("{} =", Quoted(set.markers[m]));
      for (std::size_t p = 0; p < rule.points.size(); ++p) {
        text += fmt::format("{} {} {}", p > 0 ? " +" : "", rule.points[p].weight,
                            Quoted(rule.points[p].name));
      }
      if (!rule.offset_joint.empty()) {
        text += fmt::format(" offset {} {} {} {}", Quoted(rule.offset_joint), rule.offset.x(),
                            rule.offset.y(), rule.offset.z());
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace motiondb::core
