#include "core/format/c3d_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <set>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"

namespace motiondb::core {

absl::Status C3dBytes::Require(std::size_t offset, std::size_t count, std::string_view what) const {
  if (offset <= size() && count <= size() - offset) return absl::OkStatus();
  return Error(offset, "expected {} bytes of {}, the file has only {} bytes (truncated?)", count,
               what, size());
}

std::uint8_t C3dBytes::Byte(std::size_t offset) const {
  return static_cast<std::uint8_t>(file_.bytes[offset]);
}

int C3dBytes::SignedByte(std::size_t offset) const {
  const int byte = Byte(offset);
  return byte < 128 ? byte : byte - 256;
}

std::uint16_t C3dBytes::Word(std::size_t offset) const {
  const int first = Byte(offset);
  const int second = Byte(offset + 1);
  return static_cast<std::uint16_t>(processor_ == C3dProcessor::kMips ? (first << 8) | second
                                                                      : (second << 8) | first);
}

std::int16_t C3dBytes::SignedWord(std::size_t offset) const {
  return static_cast<std::int16_t>(Word(offset));
}

float C3dBytes::Real(std::size_t offset) const {
  const std::uint32_t first = Word(offset);
  const std::uint32_t second = Word(offset + 2);
  if (processor_ == C3dProcessor::kIntel) return std::bit_cast<float>((second << 16) | first);
  const float value = std::bit_cast<float>((first << 16) | second);
  // VAX floats are IEEE floats with swapped words and an exponent bias that is larger by 2.
  return processor_ == C3dProcessor::kDec ? value / 4 : value;
}

std::string_view C3dBytes::Text(std::size_t offset, std::size_t count) const {
  return file_.bytes.substr(offset, count);
}

namespace {

// Files have about a hundred. Each uses much more memory than its bytes in the file.
constexpr std::size_t kMaxParameters = 10'000;

std::string UpperCase(std::string_view name) {
  std::string upper(name);
  for (char& c : upper) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return upper;
}

std::string_view Unpadded(std::string_view text) {
  constexpr std::string_view kPadding(" \t\0", 3);
  const auto first = text.find_first_not_of(kPadding);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kPadding) - first + 1);
}

}  // namespace

absl::StatusOr<C3dParameters> C3dParameters::Read(const C3dBytes& bytes, std::size_t start,
                                                  std::size_t end) {
  constexpr std::size_t kSectionHeader = 4;
  std::map<int, std::string> groups;
  std::map<std::pair<int, std::string>, Parameter> found;  // by group number and name
  // The last entry has a distance of 0, or points to zeros, or, in some old files, beyond the end.
  for (std::size_t next = start + kSectionHeader; next < end;) {
    // An entry: length of the name (negative if locked), number (negative for a group), name,
    // distance to the next entry, contents.
    MOTIONDB_RETURN_IF_ERROR(bytes.Require(next, 2, "a parameter"));
    const int length = std::abs(bytes.SignedByte(next));
    const int number = bytes.SignedByte(next + 1);
    if (length == 0) break;
    const std::size_t distance_at = next + 2 + static_cast<std::size_t>(length);
    MOTIONDB_RETURN_IF_ERROR(
        bytes.Require(next, distance_at + 2 - next, "a parameter's name and size"));
    const std::string name = UpperCase(bytes.Text(next + 2, static_cast<std::size_t>(length)));
    const std::size_t distance = bytes.Word(distance_at);
    if (number < 0) {
      groups[-number] = name;
    } else {
      MOTIONDB_ASSIGN_OR_RETURN(Parameter parameter, ReadParameter(bytes, distance_at + 2, name));
      if (distance != 0 && distance_at + distance < EndOf(parameter)) {
        return bytes.Error(distance_at,
                           "expected parameter '{}' to end before the next, {} bytes later",
                           Shown(name), distance);
      }
      found.insert_or_assign({number, name}, std::move(parameter));
      if (found.size() > kMaxParameters) {
        return bytes.Error(next, "expected at most {} parameters, found more", kMaxParameters);
      }
    }
    if (distance == 0) break;
    next = distance_at + distance;
  }
  C3dParameters parameters(bytes);
  for (auto& [key, parameter] : found) {
    parameters.parameters_.emplace(std::pair(groups[key.first], key.second), std::move(parameter));
  }
  return parameters;
}

std::size_t C3dParameters::EndOf(const Parameter& parameter) {
  return parameter.offset +
         parameter.count * static_cast<std::size_t>(std::abs(static_cast<int>(parameter.type)));
}

absl::StatusOr<C3dParameters::Parameter> C3dParameters::ReadParameter(const C3dBytes& bytes,
                                                                      std::size_t offset,
                                                                      std::string_view name) {
  MOTIONDB_RETURN_IF_ERROR(bytes.Require(offset, 2, "a parameter's type"));
  const int type = bytes.SignedByte(offset);
  if (type != -1 && type != 1 && type != 2 && type != 4) {
    return bytes.Error(offset, "expected the type of parameter '{}' to be -1, 1, 2 or 4, found {}",
                       Shown(name), type);
  }
  const std::size_t dimension_count = bytes.Byte(offset + 1);
  constexpr std::size_t kMaxDimensions = 7;
  if (dimension_count > kMaxDimensions) {
    return bytes.Error(offset + 1, "expected parameter '{}' to have at most 7 dimensions, found {}",
                       Shown(name), dimension_count);
  }
  MOTIONDB_RETURN_IF_ERROR(bytes.Require(offset + 2, dimension_count, "a parameter's dimensions"));
  Parameter parameter{.type = static_cast<Type>(type),
                      .dimensions = {},
                      .count = 1,
                      .offset = offset + 2 + dimension_count};
  for (std::size_t i = 0; i < dimension_count; ++i) {
    parameter.dimensions.push_back(bytes.Byte(offset + 2 + i));
    parameter.count *= parameter.dimensions.back();  // at most 255^7, which fits
  }
  const std::size_t element_size = static_cast<std::size_t>(std::abs(type));
  MOTIONDB_RETURN_IF_ERROR(bytes.Require(parameter.offset, parameter.count * element_size,
                                         fmt::format("parameter '{}'", Shown(name))));
  return parameter;
}

const C3dParameters::Parameter* C3dParameters::Find(const std::string& group,
                                                    const std::string& name) const {
  const auto found = parameters_.find({group, name});
  return found == parameters_.end() ? nullptr : &found->second;
}

std::optional<double> C3dParameters::Number(const std::string& group, const std::string& name,
                                            std::size_t element) const {
  const Parameter* parameter = Find(group, name);
  if (parameter == nullptr || element >= parameter->count) return std::nullopt;
  switch (parameter->type) {
    case Type::kByte:
      return bytes_.Byte(parameter->offset + element);
    case Type::kWord:
      return bytes_.Word(parameter->offset + 2 * element);
    case Type::kReal:
      return bytes_.Real(parameter->offset + 4 * element);
    case Type::kText:
      break;
  }
  return std::nullopt;
}

std::vector<std::string_view> C3dParameters::Strings(const std::string& group,
                                                     const std::string& name) const {
  const Parameter* parameter = Find(group, name);
  std::vector<std::string_view> strings;
  if (parameter == nullptr || parameter->type != Type::kText || parameter->count == 0) {
    return strings;
  }
  const std::size_t length = parameter->dimensions.empty() ? 1 : parameter->dimensions[0];
  for (std::size_t at = 0; at < parameter->count && strings.size() < kMaxStrings; at += length) {
    strings.push_back(Unpadded(bytes_.Text(parameter->offset + at, length)));
  }
  return strings;
}

namespace {

struct C3dUnitPart {
  std::string_view name;
  double factor;
};
constexpr std::array<C3dUnitPart, 7> kUnitPrefixes = {{{"milli", 0.001},
                                                       {"mili", 0.001},
                                                       {"centi", 0.01},
                                                       {"zenti", 0.01},
                                                       {"deci", 0.1},
                                                       {"dezi", 0.1},
                                                       {"", 1}}};
constexpr std::array<C3dUnitPart, 13> kUnitNames = {{{"meter", 1},
                                                     {"metre", 1},
                                                     {"metro", 1},
                                                     {"metri", 1},
                                                     {"dm", 0.1},
                                                     {"ft", 0.3048},
                                                     {"foot", 0.3048},
                                                     {"feet", 0.3048},
                                                     {"zoll", 0.0254},
                                                     {"pouce", 0.0254},
                                                     {"pollice", 0.0254},
                                                     {"pollici", 0.0254},
                                                     {"pulgada", 0.0254}}};

// Returns the letters in lower case, without accents.
std::string PlainLetters(std::string_view text) {
  std::string letters;
  for (const char c : ToUtf8(text)) {
    if (c >= 'a' && c <= 'z') letters += c;
    if (c >= 'A' && c <= 'Z') letters += static_cast<char>(c - 'A' + 'a');
    // Second bytes of the accented letters in UTF-8; the first is the same for all.
    if (c == '\xA8' || c == '\xA9') letters += 'e';
    if (c == '\xAD') letters += 'i';
  }
  return letters;
}

}  // namespace

std::optional<double> MetresPerC3dUnit(std::string_view text) {
  const std::string letters = PlainLetters(text);
  if (const auto known = MetresPerUnitNamed(letters)) return known;
  std::string_view unit = letters;
  if (unit.ends_with('s')) unit.remove_suffix(1);
  for (const C3dUnitPart& prefix : kUnitPrefixes) {
    if (!unit.starts_with(prefix.name)) continue;
    for (const C3dUnitPart& name : kUnitNames) {
      if (unit.substr(prefix.name.size()) == name.name) return prefix.factor * name.factor;
    }
  }
  return std::nullopt;
}

namespace {

// Returns the strings of NAME, NAME2, NAME3 ...: one parameter holds at most 255.
std::vector<std::string_view> AllStrings(const C3dParameters& parameters, const std::string& name) {
  std::vector<std::string_view> all = parameters.Strings("POINT", name);
  for (int n = 2;; ++n) {
    const auto more = parameters.Strings("POINT", fmt::format("{}{}", name, n));
    if (more.empty() || all.size() >= C3dParameters::kMaxStrings) return all;
    all.insert(all.end(), more.begin(), more.end());
  }
}

std::set<std::string_view> ComputedLabels(const C3dParameters& parameters) {
  std::set<std::string_view> computed;
  for (const char* kind : {"ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS"}) {
    for (const std::string_view label : AllStrings(parameters, kind)) computed.insert(label);
  }
  computed.erase("");
  return computed;
}

// Returns the "subject:" prefix that all labels share; empty if they differ.
std::string_view CommonSubject(const std::vector<std::string_view>& labels) {
  std::string_view subject;
  for (const std::string_view label : labels) {
    const auto colon = label.rfind(':');
    if (label.empty() || label[0] == '*') continue;  // an automatic name
    if (colon == label.npos) return {};
    if (subject.empty()) subject = label.substr(0, colon + 1);
    if (label.substr(0, colon + 1) != subject) return {};
  }
  return subject;
}

}  // namespace

std::vector<C3dMarker> C3dMarkers(const C3dParameters& parameters, int points,
                                  std::vector<std::string>& notes) {
  const std::vector<std::string_view> labels = AllStrings(parameters, "LABELS");
  const std::set<std::string_view> computed = ComputedLabels(parameters);
  const std::string_view subject = CommonSubject(labels);
  UniqueNames unique;
  std::vector<C3dMarker> markers;
  int left_out = 0;
  int unnamed = 0;
  for (std::size_t point = 0; point < static_cast<std::size_t>(points); ++point) {
    std::string_view label = point < labels.size() ? labels[point] : std::string_view();
    if (computed.contains(label)) {
      ++left_out;
      continue;
    }
    if (label.starts_with(subject)) label.remove_prefix(subject.size());
    if (label.empty()) ++unnamed;
    markers.push_back({.point = point,
                       .name = unique.Add(label.empty() ? fmt::format("point{}", point + 1)
                                                        : std::string(label))});
  }
  if (!subject.empty()) notes.push_back(fmt::format("'{}' dropped from labels", Shown(subject)));
  if (unnamed > 0) notes.push_back(fmt::format("{} points without a label", unnamed));
  if (left_out > 0) {
    notes.push_back(fmt::format("{} computed points (angles, forces ...) left out", left_out));
  }
  if (std::string note = unique.Note(); !note.empty()) notes.push_back(std::move(note));
  return markers;
}

}  // namespace motiondb::core
