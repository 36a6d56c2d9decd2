#include "server/filter/syntax.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxShownBytes = 24;

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

bool IsQuote(char c) { return c == '"' || c == '\''; }

// Whether a byte can be in a word without quotes. A dot separates words.
bool IsWordByte(char c) {
  return !IsSpace(c) && static_cast<unsigned char>(c) > ' ' && c != '\x7f' &&
         std::string_view("().,:=<>!\"'\\").find(c) == std::string_view::npos;
}

FilterSyntax Joined(FilterSyntax::Kind kind, std::size_t position,
                    std::vector<FilterSyntax> parts) {
  if (parts.size() == 1) return std::move(parts[0]);
  FilterSyntax node{.kind = kind, .position = position};
  for (FilterSyntax& part : parts) {
    if (part.kind != kind) {
      node.children.push_back(std::move(part));
      continue;
    }
    for (FilterSyntax& child : part.children) node.children.push_back(std::move(child));
  }
  return node;
}

// One function for each rule of the grammar.
class SyntaxParser {
 public:
  explicit SyntaxParser(std::string_view text) : text_(text) {}

  absl::StatusOr<std::optional<FilterSyntax>> Filter() {
    SkipSpace();
    if (AtEnd()) return std::nullopt;
    MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax tree, Expression());
    if (!AtEnd()) return Expected("the end of the filter or a '(' before it");
    return tree;
  }

 private:
  bool AtEnd() const { return next_ == text_.size(); }
  char Peek() const { return AtEnd() ? '\0' : text_[next_]; }
  bool SkipSpace() {
    const std::size_t before = next_;
    while (!AtEnd() && IsSpace(Peek())) ++next_;
    return next_ > before;
  }

  // Whether AND, OR or NOT is here, and not a longer word.
  bool IsKeyword(std::string_view word) const {
    if (!text_.substr(next_).starts_with(word)) return false;
    const std::size_t end = next_ + word.size();
    return end == text_.size() || IsSpace(text_[end]) || text_[end] == '(' || text_[end] == ')';
  }
  bool IsAnyKeyword() const { return IsKeyword("AND") || IsKeyword("OR") || IsKeyword("NOT"); }
  // Passes a keyword and the space after it.
  absl::Status PassKeyword(std::string_view word) {
    next_ += word.size();
    if (!AtEnd() && !SkipSpace()) return Expected(fmt::format("a space after {}", word));
    return absl::OkStatus();
  }

  absl::Status Expected(std::string_view what) const {
    std::string got = "the end of the filter";
    if (!AtEnd()) {
      std::size_t end = next_ + 1;
      while (end < text_.size() && IsWordByte(Peek()) && IsWordByte(text_[end])) ++end;
      const std::string_view word = text_.substr(next_, end - next_);
      got = fmt::format("'{}{}'", text::TruncateUtf8(word, kMaxShownBytes),
                        word.size() > kMaxShownBytes ? "..." : "");
    }
    return FilterError(next_, fmt::format("expected {}, got {}", what, got));
  }

  // expression: sequence {WS AND WS sequence}
  absl::StatusOr<FilterSyntax> Expression() {
    const std::size_t position = next_;
    std::vector<FilterSyntax> parts;
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax part, Sequence());
      parts.push_back(std::move(part));
      if (!IsKeyword("AND")) break;
      MOTIONDB_RETURN_IF_ERROR(PassKeyword("AND"));
    }
    return Joined(FilterSyntax::Kind::kAnd, position, std::move(parts));
  }

  // sequence: factor {WS factor}. Passes the space after it.
  absl::StatusOr<FilterSyntax> Sequence() {
    const std::size_t position = next_;
    std::vector<FilterSyntax> parts;
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax part, Factor());
      parts.push_back(std::move(part));
      const bool has_space = SkipSpace();
      if (AtEnd() || Peek() == ')') break;
      if (!has_space) return Expected("a space, or the end of the filter");
      if (IsKeyword("AND")) break;
    }
    return Joined(FilterSyntax::Kind::kAnd, position, std::move(parts));
  }

  // factor: term {WS OR WS term}
  absl::StatusOr<FilterSyntax> Factor() {
    const std::size_t position = next_;
    std::vector<FilterSyntax> parts;
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax part, Term());
      parts.push_back(std::move(part));
      const std::size_t end = next_;
      if (!SkipSpace() || !IsKeyword("OR")) {
        next_ = end;
        break;
      }
      MOTIONDB_RETURN_IF_ERROR(PassKeyword("OR"));
    }
    return Joined(FilterSyntax::Kind::kOr, position, std::move(parts));
  }

  // term: [(NOT WS | MINUS)] simple
  absl::StatusOr<FilterSyntax> Term() {
    const std::size_t position = next_;
    bool is_negated = false;
    if (IsKeyword("NOT")) {
      MOTIONDB_RETURN_IF_ERROR(PassKeyword("NOT"));
      is_negated = true;
    } else if (Peek() == '-') {
      ++next_;
      is_negated = true;
    }
    if (is_negated && (Peek() == '-' || IsKeyword("NOT"))) {
      return Expected("a comparison, a value or '(' after NOT or '-'");
    }
    MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax simple, Simple());
    if (!is_negated) return simple;
    FilterSyntax node{.kind = FilterSyntax::Kind::kNot, .position = position};
    node.children.push_back(std::move(simple));
    return node;
  }

  // simple: restriction | composite
  absl::StatusOr<FilterSyntax> Simple() {
    if (Peek() == '(') return Composite();
    if (IsAnyKeyword()) return Expected("a comparison, a value or '('");
    return Restriction();
  }

  // composite: LPAREN expression RPAREN
  absl::StatusOr<FilterSyntax> Composite() {
    if (++depth_ > kMaxFilterDepth) {
      return FilterError(next_,
                         fmt::format("expected at most {} levels of parentheses", kMaxFilterDepth));
    }
    ++next_;
    SkipSpace();
    MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax inner, Expression());
    if (Peek() != ')') return Expected("')'");
    ++next_;
    --depth_;
    return inner;
  }

  // restriction: comparable [comparator arg]
  absl::StatusOr<FilterSyntax> Restriction() {
    FilterSyntax node{.position = next_};
    MOTIONDB_ASSIGN_OR_RETURN(node.path, Member("a comparison, a value or '('"));
    const std::size_t end = next_;
    SkipSpace();
    node.comparator = ReadComparator();
    if (!node.comparator.has_value()) {
      next_ = end;
      return node;
    }
    SkipSpace();
    node.value_position = next_;
    if (Peek() == '(') {
      MOTIONDB_ASSIGN_OR_RETURN(FilterSyntax composite, Composite());
      node.children.push_back(std::move(composite));
      return node;
    }
    const std::string expected =
        fmt::format("a value after '{}'", ComparatorText(*node.comparator));
    if (IsAnyKeyword()) return Expected(expected);
    MOTIONDB_ASSIGN_OR_RETURN(const std::vector<FilterText> value, Member(expected));
    if (!AtEnd() && Peek() != ')' && !IsSpace(Peek())) {
      return Expected("a space after the value; a value with special characters needs quotes");
    }
    node.value = JoinedPath(value);
    return node;
  }

  std::optional<Comparator> ReadComparator() {
    constexpr std::pair<std::string_view, Comparator> kComparators[] = {
        {"<=", Comparator::kLessEqual}, {">=", Comparator::kGreaterEqual},
        {"!=", Comparator::kNotEqual},  {"<", Comparator::kLess},
        {">", Comparator::kGreater},    {"=", Comparator::kEqual},
        {":", Comparator::kHas}};
    for (const auto& [text, comparator] : kComparators) {
      if (!text_.substr(next_).starts_with(text)) continue;
      next_ += text.size();
      return comparator;
    }
    return std::nullopt;
  }

  // member: value {DOT field}
  absl::StatusOr<std::vector<FilterText>> Member(std::string_view expected) {
    const std::size_t position = next_;
    std::vector<FilterText> parts;
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(FilterText part, IsQuote(Peek()) ? Quoted() : Word(expected));
      parts.push_back(std::move(part));
      if (Peek() != '.') break;
      ++next_;
      expected = "a name after '.'; a value that ends in '.' needs quotes";
    }
    if (Peek() == '(' && !parts.back().is_quoted) {
      return FilterError(position, fmt::format("expected a comparison, got the function {}(); "
                                               "filters have no functions",
                                               JoinedPath(parts).text));
    }
    return parts;
  }

  absl::StatusOr<FilterText> Word(std::string_view expected) {
    FilterText word;
    for (; !AtEnd() && IsWordByte(Peek()); ++next_) {
      if (Peek() == '*') word.wildcards.push_back(word.text.size());
      word.text += Peek();
    }
    if (word.text.empty()) return Expected(expected);
    return word;
  }

  absl::StatusOr<FilterText> Quoted() {
    const std::size_t begin = next_;
    const char quote = text_[next_++];
    FilterText quoted{.is_quoted = true};
    for (; !AtEnd() && Peek() != quote; ++next_) {
      if (Peek() == '*') quoted.wildcards.push_back(quoted.text.size());
      if (Peek() != '\\') {
        quoted.text += Peek();
        continue;
      }
      ++next_;
      constexpr std::string_view kEscapes = "\\\"'*ntr";
      constexpr std::string_view kEscaped = "\\\"'*\n\t\r";
      const std::size_t escape = AtEnd() ? std::string_view::npos : kEscapes.find(Peek());
      if (escape == std::string_view::npos) {
        return Expected(R"(\\, \", \', \*, \n, \t or \r after '\')");
      }
      quoted.text += kEscaped[escape];
    }
    if (AtEnd()) {
      return Expected(fmt::format("{} to end the text that begins at byte {}", quote, begin + 1));
    }
    ++next_;
    return quoted;
  }

  std::string_view text_;
  std::size_t next_ = 0;
  int depth_ = 0;
};

}  // namespace

absl::StatusOr<std::optional<FilterSyntax>> ParseFilterSyntax(std::string_view text) {
  if (text.size() > kMaxFilterBytes) {
    return FilterError(kMaxFilterBytes, fmt::format("expected at most {} bytes, got {}",
                                                    kMaxFilterBytes, text.size()));
  }
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t bytes = text::FirstCharacter(text.substr(i)).bytes;
    if (bytes == 0) return FilterError(i, "expected UTF-8, got another byte");
    i += bytes;
  }
  return SyntaxParser(text).Filter();
}

FilterText JoinedPath(const std::vector<FilterText>& path) {
  FilterText joined = path[0];
  for (std::size_t i = 1; i < path.size(); ++i) {
    joined.text += '.';
    for (const std::size_t wildcard : path[i].wildcards) {
      joined.wildcards.push_back(joined.text.size() + wildcard);
    }
    joined.text += path[i].text;
    joined.is_quoted = joined.is_quoted || path[i].is_quoted;
  }
  return joined;
}

absl::Status FilterError(std::size_t position, std::string_view description) {
  return core::FieldViolation("filter", "byte {}: {}", position + 1, description);
}

}  // namespace motiondb::server
