#include "core/format/marker_set_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/format/marker_set_tokens.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {
namespace {

constexpr std::string_view kMagic = "motiondb-marker-set";
constexpr std::string_view kVersion = "1";

constexpr double kWeightTolerance = 1e-6;

// Makes the weights sum to 1: a rule made of several must still be within the tolerance when it is
// read again. Rounding errors stay, so that a written scheme is read back unchanged.
void Normalize(MarkerRule& rule) {
  double sum = 0;
  for (const WeightedPoint& point : rule.points) sum += point.weight;
  constexpr double kRounding = 1e-12;
  if (std::abs(sum - 1) < kRounding) return;
  for (WeightedPoint& point : rule.points) point.weight /= sum;
}

class Reader {
 public:
  Reader() = default;
  // For a file that contains only mappings of this set.
  explicit Reader(const MarkerScheme& base) : extends_only_(true) {
    scheme_.set = base.set;
    scheme_.default_rules = base.default_rules;
    // Stores of version 0.1 have the standard set without its default rules.
    const bool is_standard = base.set.markers == StandardScheme().set.markers;
    if (base.default_rules.empty() && is_standard) {
      scheme_.default_rules = StandardScheme().default_rules;
    }
  }

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
    if (word == "extend") return ReadExtend(tokens);
    if (extends_only_ && word != "mapping" && word != "signature") {
      return InvalidArgument(
          "expected only mappings for marker set '{}' (mapping, signature or MARKER = ...), got "
          "'{}'",
          scheme_.set.name, word);
    }
    if (has_base_ && (word == "name" || word == "marker" || word == "hips" || word == "leg")) {
      return InvalidArgument("expected only mappings and rules after 'extend {}', got '{}'",
                             scheme_.set.name, word);
    }
    if (word == "name") return ReadName(tokens);
    if (word == "marker") return ReadMarker(tokens);
    if (word == "hips") return ReadHips(tokens);
    if (word == "leg") return ReadLeg(tokens);
    if (word == "mapping") return ReadMapping(tokens);
    if (word == "signature") return ReadSignature(tokens);
    return InvalidArgument(
        "expected name, extend, marker, hips, leg, mapping, signature or MARKER = ..., got '{}'",
        word);
  }

  absl::StatusOr<std::vector<MarkerMapping>> FinishMappings() {
    if (!started_) return InvalidArgument("expected '{} {}' first", kMagic, kVersion);
    MOTIONDB_RETURN_IF_ERROR(FinishMapping());
    if (scheme_.mappings.empty()) return InvalidArgument("expected at least one 'mapping NAME'");
    return std::move(scheme_.mappings);
  }

  absl::StatusOr<MarkerScheme> Finish() {
    if (!started_) return InvalidArgument("expected '{} {}' first", kMagic, kVersion);
    if (scheme_.set.name.empty()) return InvalidArgument("expected a line 'name NAME'");
    if (scheme_.set.markers.empty()) return InvalidArgument("expected at least one 'marker NAME'");
    MOTIONDB_RETURN_IF_ERROR(FinishMapping());
    // A mapping of the file replaces one of the base with the same name.
    for (MarkerMapping& mapping : base_mappings_) {
      if (!HasMapping(mapping.name)) scheme_.mappings.push_back(std::move(mapping));
    }
    if (scheme_.mappings.size() > kMaxMappings) {
      return InvalidArgument("expected at most {} mappings, got {} with those of the base",
                             kMaxMappings, scheme_.mappings.size());
    }
    const bool has_defaults = std::ranges::any_of(
        scheme_.default_rules, [](const MarkerRule& rule) { return !rule.points.empty(); });
    scheme_.default_rules.resize(has_defaults ? scheme_.set.markers.size() : 0);
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

  bool HasMapping(const std::string& name) const {
    return std::ranges::find(scheme_.mappings, name, &MarkerMapping::name) !=
           scheme_.mappings.end();
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
    if (extends_only_) {
      if (tokens.size() == 2 && tokens[1].text == scheme_.set.name) return absl::OkStatus();
      return InvalidArgument("expected 'extend {}', the marker set of the database",
                             scheme_.set.name);
    }
    const MarkerScheme& base = StandardScheme();
    if (tokens.size() != 2 || tokens[1].text != base.set.name) {
      return InvalidArgument("expected 'extend {}'", base.set.name);
    }
    if (!scheme_.set.name.empty() || !scheme_.set.markers.empty()) {
      return InvalidArgument("expected 'extend {}' instead of a name and markers", base.set.name);
    }
    scheme_.set = base.set;
    scheme_.default_rules = base.default_rules;
    base_mappings_ = base.mappings;
    has_base_ = true;
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
    constexpr std::size_t kMaxNameBytes = 255;
    if (extends_only_ && (tokens[1].text.empty() || tokens[1].text.size() > kMaxNameBytes)) {
      return InvalidArgument("expected a mapping name of 1 to {} bytes", kMaxNameBytes);
    }
    if (extends_only_ && HasMapping(tokens[1].text)) {
      return InvalidArgument("expected unique mappings, got '{}' twice", tokens[1].text);
    }
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
    if (extends_only_ && !mapping_) {
      return InvalidArgument("expected 'mapping NAME' before its rules");
    }
    std::vector<MarkerRule>& defaults = scheme_.default_rules;
    if (!mapping_) defaults.resize(scheme_.set.markers.size());
    MarkerRule& rule = mapping_ ? mapping_->rules[marker] : defaults[marker];
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
    if (std::abs(sum - 1) > kWeightTolerance) {
      return InvalidArgument("expected weights that sum to 1, got {}", sum);
    }
    Normalize(rule);
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
    for (const WeightedPoint& part : scheme_.default_rules[marker].points) {
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
    Normalize(expanded);
    if (!expanded.points.empty()) return expanded;
    return InvalidArgument("mapping '{}' has no rule for marker '{}'", mapping_->name,
                           scheme_.set.markers[marker]);
  }

  absl::Status FinishMapping() {
    if (!mapping_) return absl::OkStatus();
    scheme_.default_rules.resize(scheme_.set.markers.size());
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

  bool extends_only_ = false;
  bool has_base_ = false;
  bool started_ = false;
  MarkerScheme scheme_;
  std::optional<MarkerMapping> mapping_;
  std::vector<MarkerMapping> base_mappings_;  // of the extended set
};

// Reads all lines. INVALID_ARGUMENT names file and line.
absl::Status ReadLines(const SourceFile& file, Reader& reader) {
  int number = 0;
  for (std::string_view rest = file.bytes; !rest.empty();) {
    ++number;
    auto tokens = Tokens(NextLine(rest));
    absl::Status status = tokens.status();
    if (tokens.ok() && !tokens->empty()) status = reader.ReadLine(*tokens);
    if (!status.ok())
      return InvalidArgument("{}:{}: {}", file.name, number, std::string(status.message()));
  }
  return absl::OkStatus();
}

template <typename Result>
absl::StatusOr<Result> NamingFile(const SourceFile& file, absl::StatusOr<Result> result) {
  if (result.ok()) return result;
  return InvalidArgument("{}: {}", file.name, std::string(result.status().message()));
}

void AppendRule(const MarkerSet& set, std::size_t marker, const MarkerRule& rule,
                std::string& text) {
  text += fmt::format("{} =", QuotedName(set.markers[marker]));
  for (std::size_t p = 0; p < rule.points.size(); ++p) {
    text += fmt::format("{} {} {}", p > 0 ? " +" : "", rule.points[p].weight,
                        QuotedName(rule.points[p].name));
  }
  if (!rule.offset_joint.empty()) {
    text += fmt::format(" offset {} {} {} {}", QuotedName(rule.offset_joint), rule.offset.x(),
                        rule.offset.y(), rule.offset.z());
  }
  text += '\n';
}

}  // namespace

absl::StatusOr<MarkerScheme> ReadMarkerSetFile(SourceFile file) {
  Reader reader;
  MOTIONDB_RETURN_IF_ERROR(ReadLines(file, reader));
  return NamingFile(file, reader.Finish());
}

absl::StatusOr<std::vector<MarkerMapping>> ReadMappings(SourceFile file, const MarkerScheme& base) {
  Reader reader(base);
  MOTIONDB_RETURN_IF_ERROR(ReadLines(file, reader));
  return NamingFile(file, reader.FinishMappings());
}

std::string WriteMapping(const MarkerSet& set, const MarkerMapping& mapping) {
  std::string text = fmt::format("mapping {}\nsignature", QuotedName(mapping.name));
  for (const std::string& point : mapping.signature) text += ' ' + QuotedName(point);
  text += '\n';
  for (std::size_t m = 0; m < mapping.rules.size(); ++m) {
    AppendRule(set, m, mapping.rules[m], text);
  }
  return text;
}

std::string WriteMarkerSetFile(const MarkerScheme& scheme) {
  const MarkerSet& set = scheme.set;
  std::string text = fmt::format("{} {}\nname {}\n", kMagic, kVersion, QuotedName(set.name));
  for (const std::string& marker : set.markers)
    text += fmt::format("marker {}\n", QuotedName(marker));
  const auto name = [&](int marker) { return QuotedName(set.markers[marker]); };
  text += fmt::format("hips {} {}\n", name(set.landmarks.left_hip), name(set.landmarks.right_hip));
  for (const auto& leg : set.landmarks.legs) {
    text += fmt::format("leg {} {} {}\n", name(leg[0]), name(leg[1]), name(leg[2]));
  }
  for (std::size_t m = 0; m < scheme.default_rules.size(); ++m) {
    if (!scheme.default_rules[m].points.empty()) AppendRule(set, m, scheme.default_rules[m], text);
  }
  for (const MarkerMapping& mapping : scheme.mappings) text += WriteMapping(set, mapping);
  return text;
}

}  // namespace motiondb::core
