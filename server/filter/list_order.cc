#include "server/filter/list_order.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

constexpr std::string_view kOrderSpace = " \t\n\r";

absl::Status OrderError(std::size_t position, std::string_view description) {
  return core::FieldViolation("order_by", "byte {}: {}", position + 1, description);
}

bool IsOrdered(FieldKind kind, const ResolvedField& field) {
  switch (kind) {
    case FieldKind::kText:
    case FieldKind::kNumber:
    case FieldKind::kDuration:
    case FieldKind::kTime:
    case FieldKind::kFormat:
    case FieldKind::kSource:
      return !field.is_of_any_segment;
    case FieldKind::kUserField:
      return !field.user_field.empty();
    default:
      return false;
  }
}

void AppendInteger(std::uint64_t value, std::string& key) {
  for (int shift = 56; shift >= 0; shift -= 8) key += static_cast<char>(value >> shift);
}

// Ends a text so that a prefix of it is before it.
void AppendEndedText(std::string_view text, std::string& key) {
  for (const char c : text) {
    key += c;
    if (c == '\0') key += '\xff';
  }
  key.append("\0\1", 2);
}

// Appends a value after the rank of its type.
struct ContentKey {
  std::string& key;

  void operator()(std::monostate) const { key += '\0'; }
  void operator()(bool value) const {
    key += '\1';
    key += value ? '\1' : '\0';
  }
  void operator()(double value) const {
    key += '\2';
    const auto bits = std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value);  // no -0
    constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
    AppendInteger((bits & kSign) != 0 ? ~bits : bits | kSign, key);
  }
  void operator()(storage::FieldTime value) const {
    key += '\3';
    AppendInteger(static_cast<std::uint64_t>(value.time_us) ^ (std::uint64_t{1} << 63), key);
  }
  void operator()(std::string_view value) const {
    key += '\4';
    AppendEndedText(value, key);
  }
};

// Returns the text without space around it; `position` becomes that of its first byte.
std::string_view Trimmed(std::string_view text, std::size_t& position) {
  const std::size_t first = text.find_first_not_of(kOrderSpace);
  if (first == std::string_view::npos) return {};
  position += first;
  return text.substr(first, text.find_last_not_of(kOrderSpace) + 1 - first);
}

}  // namespace

ListOrder::ListOrder(FilterSubject subject) {
  if (subject == FilterSubject::kClips) return;
  terms_ = {{"clip", {FilterField::kClipId, FieldKind::kText}},
            {"track", {FilterField::kSegmentTrack, FieldKind::kText}},
            {"start", {FilterField::kSegmentStart, FieldKind::kDuration}}};
}

absl::StatusOr<ListOrder> ListOrder::Parse(std::string_view order_by, FilterSubject subject) {
  ListOrder order(subject);
  std::size_t start = 0;
  if (Trimmed(order_by, start).empty()) return order;
  if (order_by.size() > kMaxOrderBytes) {
    return OrderError(kMaxOrderBytes, fmt::format("expected at most {} bytes, got {}",
                                                  kMaxOrderBytes, order_by.size()));
  }
  const bool is_of_clips = subject == FilterSubject::kClips;
  const FieldScope scope = is_of_clips ? FieldScope::kClip : FieldScope::kSegment;
  order.terms_.clear();
  for (std::size_t begin = 0; begin <= order_by.size();) {
    const std::size_t end = std::min(order_by.find(',', begin), order_by.size());
    std::size_t position = begin;
    const std::string_view part = Trimmed(order_by.substr(begin, end - begin), position);
    const std::string_view name = part.substr(0, part.find_first_of(kOrderSpace));
    std::size_t direction_position = position + name.size();
    const std::string_view direction = Trimmed(part.substr(name.size()), direction_position);
    begin = end + 1;
    if (name.empty()) return OrderError(position, "expected a field");
    auto field = ResolveField(name, scope);
    if (const auto* expected = std::get_if<std::string>(&field)) {
      return OrderError(position, fmt::format("expected {}", *expected));
    }
    auto& resolved = std::get<ResolvedField>(field);
    if (!IsOrdered(resolved.kind, resolved)) {
      return OrderError(position,
                        fmt::format("expected a field with one value, got '{}', which has several "
                                    "or a long one",
                                    name));
    }
    if (direction != "desc" && direction != "asc" && !direction.empty()) {
      return OrderError(direction_position,
                        fmt::format("expected desc, asc or ',', got '{}'", direction));
    }
    if (order.terms_.size() == kMaxOrderFields) {
      return OrderError(position, fmt::format("expected at most {} fields", kMaxOrderFields));
    }
    order.terms_.push_back({std::string(name), std::move(resolved), direction == "desc"});
  }
  const auto& first = order.terms_[0];  // nothing is behind the id of a clip
  if (is_of_clips && first.field.field == FilterField::kClipId && !first.is_descending) {
    order.terms_.clear();
  }
  return order;
}

std::string ListOrder::Text() const {
  std::string text;
  for (const Term& term : terms_) {
    text += fmt::format("{}{}{}", text.empty() ? "" : ", ", term.name,
                        term.is_descending ? " desc" : "");
  }
  return text;
}

void ListOrder::AppendKey(const CatalogClip& clip, const CatalogSegment* segment,
                          std::string& key) const {
  for (const Term& term : terms_) {
    const std::size_t begin = key.size();
    std::visit(ContentKey{key}, ContentOf(term.field, clip, segment));
    if (!term.is_descending) continue;
    for (std::size_t i = begin; i < key.size(); ++i) key[i] = static_cast<char>(~key[i]);
  }
  if (segment == nullptr) {
    key += clip.id;
    return;
  }
  AppendEndedText(clip.id, key);
  key += segment->id;
}

std::string ListOrder::KeyOf(const CatalogClip& clip, const CatalogSegment* segment) const {
  std::string key;
  AppendKey(clip, segment, key);
  return key;
}

}  // namespace motiondb::server
