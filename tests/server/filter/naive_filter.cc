#include "tests/server/filter/naive_filter.h"

#include <algorithm>

namespace motiondb::tests {
namespace {

using Kind = NaiveFilter::Kind;

constexpr const char* kTextFields[] = {"name", "label", "subject", "title", "file_name", "take"};
constexpr const char* kSecondFields[] = {"duration"};
constexpr const char* kSegmentTexts[] = {"name", "clip", "track", "label", "author"};
constexpr const char* kSegmentSeconds[] = {"start", "end", "duration"};
constexpr const char* kComparators[] = {"=", "!=", "<", "<=", ">", ">=", ":", "*"};
constexpr const char* kEqualities[] = {"=", "!=", ":", "*"};
constexpr std::int64_t kDayUs = 86'400'000'000;

NaiveLiteral Literal(std::string text, bool is_quoted) {
  NaiveLiteral literal{.text = std::move(text), .is_quoted = is_quoted};
  literal.is_wildcard.assign(literal.text.size(), false);
  return literal;
}

bool NeedsQuotes(const NaiveLiteral& literal) {
  const std::string& text = literal.text;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(text[i])) != 0 ||
                          static_cast<unsigned char>(text[i]) >= 128 || literal.is_wildcard[i] ||
                          (i > 0 && i + 1 < text.size() && (text[i] == '.' || text[i] == '-'));
    if (!is_plain) return true;
  }
  return text.empty();
}

NaiveLiteral RandomText(Random& random) {
  constexpr const char* kTexts[] = {"",     "walk", "Walk",    "walk slowly", "run",   "jump*",
                                    "jump", "c3",   "a\"b\\c", "\xc3\xa4rm",  "left",  "v1.2",
                                    "a",    "s1",   "action",  "carries",     ".bvh",  "left-hand",
                                    "true", "1",    "-1",      "x\n\t\ry'z",  "and so"};
  NaiveLiteral literal = Literal(OneOf(random, kTexts), false);
  for (int count = Below(random, 3); count > 0 && Below(random, 2) == 0; --count) {
    const auto at = Below(random, static_cast<int>(literal.text.size()) + 1);
    if (at > 0 && literal.text[static_cast<std::size_t>(at) - 1] == '\xc3') continue;
    literal.text.insert(literal.text.begin() + at, '*');
    literal.is_wildcard.insert(literal.is_wildcard.begin() + at, true);
  }
  literal.is_quoted = NeedsQuotes(literal) || Below(random, 2) == 0;
  return literal;
}

NaiveLiteral RandomSeconds(Random& random, bool may_have_unit) {
  constexpr const char* kNumbers[] = {"0", "0.5", "1", "2.5", "10", "1e1", "-1", "1.5", "100"};
  std::string text = OneOf(random, kNumbers);
  if (may_have_unit && Below(random, 2) == 0) text += "s";
  return Literal(text, Below(random, 4) == 0);
}

NaiveLiteral RandomTimeLiteral(Random& random) {
  struct Time {
    const char* text;
    std::int64_t begin;
    std::int64_t size;
  };
  constexpr std::int64_t kFirst = 20'575 * kDayUs;  // 2026-05-02
  const Time kTimes[] = {{"2026-05-02", kFirst, kDayUs},
                         {"2026-05-03", kFirst + kDayUs, kDayUs},
                         {"2026-05-02T00:00:00Z", kFirst, 1},
                         {"2026-05-02T14:00:00+02:00", kFirst + kDayUs / 2, 1},
                         {"2026-05-02T23:59:59.999999Z", kFirst + kDayUs - 1, 1}};
  const Time time = OneOf(random, kTimes);
  NaiveLiteral literal = Literal(time.text, time.size == 1 || Below(random, 2) == 0);
  literal.times_us = {time.begin, time.begin + time.size};
  return literal;
}

NaiveLiteral RandomUserLiteral(Random& random) {
  switch (Below(random, 4)) {
    case 0:
      return RandomText(random);
    case 1:
      return RandomSeconds(random, true);
    case 2:
      return RandomTimeLiteral(random);
    default:
      return Literal(Below(random, 2) == 0 ? "true" : "false", Below(random, 3) == 0);
  }
}

NaiveFilter Comparison(Random& random, const std::string& field, NaiveLiteral literal,
                       bool has_order = true) {
  NaiveFilter filter{.kind = Kind::kComparison, .field = field};
  filter.comparator = has_order ? OneOf(random, kComparators) : OneOf(random, kEqualities);
  filter.literals = {std::move(literal)};
  // A wildcard alone after `:` is the presence.
  const NaiveLiteral& value = filter.literals[0];
  if (filter.comparator == ":" && value.text == "*" && value.is_wildcard[0])
    filter.comparator = "*";
  return filter;
}

NaiveFilter SegmentComparison(Random& random, const std::string& prefix) {
  switch (Below(random, 5)) {
    case 0:
      return Comparison(random, prefix + OneOf(random, kSegmentSeconds),
                        RandomSeconds(random, true));
    case 1:
      return Comparison(random, prefix + "confidence", RandomSeconds(random, false));
    case 2:
      return Comparison(random, prefix + (Below(random, 2) == 0 ? "create_time" : "update_time"),
                        RandomTimeLiteral(random));
    case 3: {
      constexpr const char* kNames[] = {"person", "import", "suggestion"};
      return Comparison(random, prefix + "source", Literal(OneOf(random, kNames), false), false);
    }
    default:
      return Comparison(random, prefix + OneOf(random, kSegmentTexts), RandomText(random));
  }
}

NaiveFilter ClipComparison(Random& random, const std::string& prefix) {
  switch (Below(random, 10)) {
    case 0:
      return Comparison(random, prefix + OneOf(random, kSecondFields), RandomSeconds(random, true));
    case 1:
      return Comparison(random, prefix + "frames", RandomSeconds(random, false));
    case 2:
      return Comparison(random, prefix + (Below(random, 2) == 0 ? "create_time" : "update_time"),
                        RandomTimeLiteral(random));
    case 3:
      return Comparison(random, prefix + "format",
                        Literal(Below(random, 2) == 0 ? "bvh" : "dae", false), false);
    case 4:
      return Comparison(random, prefix + "tags", RandomText(random), false);
    case 5:
      return SegmentComparison(random, prefix + "segment.");
    case 6: {
      if (Below(random, 2) == 0) return Comparison(random, prefix + "track", RandomText(random));
      NaiveFilter filter = Comparison(random, prefix + "description", RandomText(random));
      const bool is_presence = filter.literals[0].text == "*" || filter.comparator == "*";
      filter.comparator = is_presence ? "*" : ":";
      return filter;
    }
    case 7:
    case 8:
      return Comparison(random, prefix + (Below(random, 2) == 0 ? "fields.x" : "fields.score"),
                        RandomUserLiteral(random));
    default:
      return Comparison(random, prefix + OneOf(random, kTextFields), RandomText(random));
  }
}

NaiveFilter Values(Random& random, const std::string& field) {
  NaiveFilter filter{.kind = Kind::kValues, .field = field};
  filter.comparator = Below(random, 2) == 0 ? "=" : ":";
  for (int count = 1 + Below(random, 3); count > 0; --count) {
    NaiveLiteral literal = RandomText(random);
    if (literal.text == "*") literal = Literal("walk", true);
    filter.literals.push_back(std::move(literal));
  }
  return filter;
}

NaiveFilter RandomLeaf(Random& random, bool is_of_segment, bool has_clip, int depth) {
  const int kind = Below(random, 8);
  if (kind == 0) {
    NaiveFilter search{.kind = Kind::kSearch};
    search.field = is_of_segment ? "segment" : "clip";
    search.literals = {RandomText(random)};
    return search;
  }
  if (kind == 1) return Values(random, is_of_segment ? "label" : "subject");
  if (!is_of_segment) {
    if (kind == 2 && depth > 0) {
      NaiveFilter one{.kind = Kind::kOneSegment};
      one.children.push_back(RandomLeaf(random, true, false, 0));
      if (Below(random, 2) == 0) {
        NaiveFilter both{.kind = Below(random, 2) == 0 ? Kind::kAnd : Kind::kOr};
        both.children = {one.children[0], RandomLeaf(random, true, false, 0)};
        one.children = {std::move(both)};
      }
      return one;
    }
    return ClipComparison(random, "");
  }
  return has_clip && kind < 4 ? ClipComparison(random, "clip.") : SegmentComparison(random, "");
}

NaiveFilter RandomTree(Random& random, bool is_of_segment, int depth) {
  const int kind = depth == 0 ? 3 : Below(random, 5);
  if (kind > 2) return RandomLeaf(random, is_of_segment, is_of_segment, depth);
  NaiveFilter filter{.kind = kind == 0 ? Kind::kAnd : kind == 1 ? Kind::kOr : Kind::kNot};
  const int count = kind == 2 ? 1 : 2 + Below(random, 2);
  for (int i = 0; i < count; ++i) {
    filter.children.push_back(RandomTree(random, is_of_segment, depth - 1));
  }
  return filter;
}

std::string Space(Random& random) {
  return OneOf(random, std::vector<std::string>{" ", "  ", "\t\n"});
}
std::string MaybeSpace(Random& random) { return Below(random, 3) == 0 ? Space(random) : ""; }

std::string WriteLiteral(Random& random, const NaiveLiteral& literal) {
  if (!literal.is_quoted) return literal.text;
  const char quote = Below(random, 2) == 0 ? '"' : '\'';
  std::string written(1, quote);
  for (std::size_t i = 0; i < literal.text.size(); ++i) {
    const char c = literal.text[i];
    if (c == '\n' && Below(random, 2) == 0) {
      written += "\\n";
      continue;
    }
    const bool is_escaped = c == '\\' || c == quote || (c == '*' && !literal.is_wildcard[i]) ||
                            ((c == '"' || c == '\'') && Below(random, 2) == 0);
    if (is_escaped) written += '\\';
    written += c;
  }
  return written + quote;
}

std::string InParentheses(Random& random, const std::string& text) {
  return "(" + MaybeSpace(random) + text + MaybeSpace(random) + ")";
}

// Writes a part that stands beside others of kind `outer`.
std::string WritePart(Random& random, const NaiveFilter& filter, Kind outer) {
  const std::string written = WriteFilter(random, filter);
  const bool is_looser = filter.kind == Kind::kAnd && outer == Kind::kOr;
  const bool is_group =
      filter.kind == Kind::kAnd || filter.kind == Kind::kOr || filter.kind == Kind::kNot;
  const bool needs = is_looser || (outer == Kind::kNot && is_group);
  return needs || Below(random, 8) == 0 ? InParentheses(random, written) : written;
}

std::string WriteComparison(Random& random, const NaiveFilter& filter) {
  std::string written = filter.field + MaybeSpace(random);
  written += filter.comparator == "*" ? ":" : filter.comparator;
  written += MaybeSpace(random);
  if (filter.comparator == "*") return written + "*";
  if (filter.kind == Kind::kComparison) return written + WriteLiteral(random, filter.literals[0]);
  std::string values;
  for (const NaiveLiteral& literal : filter.literals) {
    if (!values.empty()) values += Space(random) + "OR" + Space(random);
    NaiveLiteral value = literal;
    value.is_quoted = true;
    values += WriteLiteral(random, value);
  }
  return written + InParentheses(random, values);
}

}  // namespace

NaiveFilter RandomFilter(Random& random, server::FilterSubject subject, int depth) {
  return RandomTree(random, subject == server::FilterSubject::kSegments, depth);
}

std::string WriteFilter(Random& random, const NaiveFilter& filter) {
  switch (filter.kind) {
    case Kind::kSearch:
      return WriteLiteral(random, filter.literals[0]);
    case Kind::kComparison:
    case Kind::kValues:
      return WriteComparison(random, filter);
    case Kind::kOneSegment:
      return "segment:" + MaybeSpace(random) +
             InParentheses(random, WriteFilter(random, filter.children[0]));
    case Kind::kNot:
      return (Below(random, 2) == 0 ? "-" : "NOT" + Space(random)) +
             WritePart(random, filter.children[0], Kind::kNot);
    default:
      break;
  }
  std::string written;
  for (const NaiveFilter& child : filter.children) {
    if (!written.empty()) {
      const bool is_implicit = filter.kind == Kind::kAnd && Below(random, 2) == 0;
      written += Space(random);
      if (!is_implicit) written += (filter.kind == Kind::kAnd ? "AND" : "OR") + Space(random);
    }
    written += WritePart(random, child, filter.kind);
  }
  return written;
}

bool NaivePasses(const NaiveFilter& filter, const StoredClip& clip,
                 const storage::SegmentRecord* segment) {
  const auto passes = [&](const NaiveFilter& child) { return NaivePasses(child, clip, segment); };
  const auto& children = filter.children;
  switch (filter.kind) {
    case Kind::kAnd:
      return std::all_of(children.begin(), children.end(), passes);
    case Kind::kOr:
      return std::any_of(children.begin(), children.end(), passes);
    case Kind::kNot:
      return !passes(children[0]);
    case Kind::kOneSegment:
      return std::any_of(clip.segments.begin(), clip.segments.end(),
                         [&](const auto& each) { return NaivePasses(children[0], clip, &each); });
    case Kind::kSearch: {
      const auto contains = [&](const std::string& name) {
        const NaiveField field = NaiveFieldOf(name, clip, segment);
        return std::any_of(field.values.begin(), field.values.end(), [&](const auto& value) {
          return NaiveContains(std::get<std::string>(value), filter.literals[0]);
        });
      };
      if (filter.field == "segment") return contains("label") || contains("clip");
      return contains("name") || contains("label") || contains("title") || contains("tags");
    }
    default:
      break;
  }
  const NaiveField field = NaiveFieldOf(filter.field, clip, segment);
  return std::any_of(filter.literals.begin(), filter.literals.end(), [&](const auto& literal) {
    return NaiveCompare(filter.comparator, field, literal);
  });
}

}  // namespace motiondb::tests
