#include <algorithm>

#include "server/filter/syntax.h"

namespace motiondb::server {
namespace {

std::string PrintText(const FilterText& text) {
  if (!text.is_quoted) return text.text;
  std::string printed = "\"";
  for (std::size_t i = 0; i < text.text.size(); ++i) {
    const char c = text.text[i];
    const bool is_wildcard = std::binary_search(text.wildcards.begin(), text.wildcards.end(), i);
    if (c == '\n' || c == '\t' || c == '\r') {
      printed += '\\';
      printed += c == '\n' ? 'n' : c == '\t' ? 't' : 'r';
      continue;
    }
    if (c == '"' || c == '\\' || (c == '*' && !is_wildcard)) printed += '\\';
    printed += c;
  }
  return printed + '"';
}

std::string InParentheses(const std::string& text) { return "(" + text + ")"; }

std::string PrintRestriction(const FilterSyntax& node) {
  std::string printed;
  for (const FilterText& part : node.path) {
    if (!printed.empty()) printed += '.';
    printed += PrintText(part);
  }
  if (!node.comparator.has_value()) return printed;
  const std::string comparator(ComparatorText(*node.comparator));
  printed += node.comparator == Comparator::kHas ? comparator : " " + comparator + " ";
  return printed + (node.children.empty() ? PrintText(node.value)
                                          : InParentheses(PrintFilter(node.children[0])));
}

}  // namespace

std::string_view ComparatorText(Comparator comparator) {
  switch (comparator) {
    case Comparator::kEqual:
      return "=";
    case Comparator::kNotEqual:
      return "!=";
    case Comparator::kLess:
      return "<";
    case Comparator::kLessEqual:
      return "<=";
    case Comparator::kGreater:
      return ">";
    case Comparator::kGreaterEqual:
      return ">=";
    case Comparator::kHas:
      return ":";
  }
  return "";
}

std::string PrintFilter(const FilterSyntax& syntax) {
  using Kind = FilterSyntax::Kind;
  if (syntax.kind == Kind::kRestriction) return PrintRestriction(syntax);
  if (syntax.kind == Kind::kNot) {
    const FilterSyntax& child = syntax.children[0];
    const std::string printed = PrintFilter(child);
    return "NOT " + (child.kind == Kind::kRestriction ? printed : InParentheses(printed));
  }
  std::string printed;
  for (const FilterSyntax& child : syntax.children) {
    if (!printed.empty()) printed += syntax.kind == Kind::kAnd ? " AND " : " OR ";
    const std::string part = PrintFilter(child);
    printed += syntax.kind == Kind::kOr && child.kind == Kind::kAnd ? InParentheses(part) : part;
  }
  return printed;
}

}  // namespace motiondb::server
