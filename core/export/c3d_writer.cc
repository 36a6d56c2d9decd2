#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/export/file_bytes.h"
#include "core/export/writers.h"
#include "core/format/c3d_file.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "text/utf8.h"

namespace motiondb::core {
namespace {

// Limits of the format: a length or count of one byte, or of 16 bits.
constexpr std::size_t kMaxLabelBytes = 255;
constexpr std::size_t kMaxLabelsOfParameter = 255;
constexpr std::size_t kMaxParameterBlocks = 255;
constexpr std::size_t kMaxC3dPoints = 65'535;
constexpr std::size_t kMaxWord = 65'535;

constexpr float kMillimetresPerMetre = 1000;
constexpr int kParameterBlock = 2;  // the first is block 1
constexpr float kLargestInteger = 32'000;

std::uint16_t LowWord(std::size_t value) { return static_cast<std::uint16_t>(value & 0xFFFF); }
std::uint16_t HighWord(std::size_t value) { return LowWord(value >> 16); }
std::uint16_t SaturatedWord(std::size_t value) { return LowWord(std::min(value, kMaxWord)); }

// The parameter section. Groups have numbers from 1.
class C3dSectionWriter {
 public:
  void Group(std::string_view name) {
    ++group_;
    Begin(name, -group_);
    AppendWord16(3, bytes_);  // from here to the next entry
    bytes_ += '\0';           // no description
  }

  // Parameters of the last group. Several words are an array.
  void Words(std::string_view name, std::span<const std::uint16_t> words) {
    std::string contents;
    for (const std::uint16_t word : words) AppendWord16(word, contents);
    const bool is_array = words.size() > 1;
    Parameter(name, 2, is_array ? std::string(1, static_cast<char>(words.size())) : "", contents);
  }
  void Word(std::string_view name, std::uint16_t word) { Words(name, std::array{word}); }
  void Real(std::string_view name, float value) {
    std::string contents;
    AppendReal(value, contents);
    Parameter(name, 4, "", contents);
  }
  void Text(std::string_view name, std::string_view text) {
    Parameter(name, -1, std::string(1, static_cast<char>(text.size())), text);
  }
  void Texts(std::string_view name, std::span<const std::string> texts) {
    std::size_t length = 0;
    for (const std::string& text : texts) length = std::max(length, text.size());
    std::string contents;
    for (const std::string& text : texts) {
      contents += text;
      contents.append(length - text.size(), ' ');
    }
    const std::array dimensions = {static_cast<char>(length), static_cast<char>(texts.size())};
    Parameter(name, -1, {dimensions.data(), dimensions.size()}, contents);
  }

  // Blocks of the section, with its header and the zero that ends it.
  std::size_t Blocks() const { return (kHeader + bytes_.size() + kC3dBlock) / kC3dBlock; }

  // REQUIRES: Blocks() <= kMaxParameterBlocks.
  void AppendTo(std::string& file) const {
    const std::size_t end = file.size() + Blocks() * kC3dBlock;
    file += '\x01';
    file += '\x50';
    file += static_cast<char>(Blocks());
    file += static_cast<char>(C3dProcessor::kIntel);
    file += bytes_;
    file.resize(end, '\0');
  }

 private:
  static constexpr std::size_t kHeader = 4;

  void Begin(std::string_view name, int number) {
    bytes_ += static_cast<char>(name.size());
    bytes_ += static_cast<char>(number);
    bytes_ += name;
  }

  void Parameter(std::string_view name, int type, std::string_view dimensions,
                 std::string_view contents) {
    Begin(name, group_);
    const std::size_t size = 2 + 2 + dimensions.size() + contents.size() + 1;
    AppendWord16(LowWord(size), bytes_);  // from here to the next entry
    bytes_ += static_cast<char>(type);
    bytes_ += static_cast<char>(dimensions.size());
    bytes_ += dimensions;
    bytes_ += contents;
    bytes_ += '\0';  // no description
  }

  std::string bytes_;
  int group_ = 0;
};

// What the header and the parameters repeat.
struct C3dNumbers {
  std::size_t points = 0;
  std::size_t frames = 0;
  float rate_hz = 0;
  float scale = 0;  // negative: points are real numbers
};

C3dNumbers NumbersOf(const MarkerMotion& motion) {
  // Readers that convert to 16-bit integers divide by the scale.
  float largest_mm = kLargestInteger / 100;
  for (const float value : motion.positions_m.reshaped()) {
    if (!std::isnan(value))
      largest_mm = std::max(largest_mm, kMillimetresPerMetre * std::abs(value));
  }
  return {.points = motion.names.size(),
          .frames = static_cast<std::size_t>(motion.positions_m.rows()),
          .rate_hz = static_cast<float>(motion.frame_rate_hz),
          .scale = -largest_mm / kLargestInteger};
}

C3dSectionWriter WriteParameters(const C3dNumbers& numbers, std::span<const std::string> labels,
                                 std::size_t data_block) {
  C3dSectionWriter section;
  section.Group("POINT");
  section.Word("USED", LowWord(numbers.points));
  section.Word("FRAMES", SaturatedWord(numbers.frames));
  section.Word("DATA_START", LowWord(data_block));
  section.Real("SCALE", numbers.scale);
  section.Real("RATE", numbers.rate_hz);
  section.Text("UNITS", "mm");
  section.Text("X_SCREEN", "+X");
  section.Text("Y_SCREEN", "+Z");
  for (std::size_t first = 0, n = 1; first < labels.size(); first += kMaxLabelsOfParameter, ++n) {
    const auto some = labels.subspan(first, std::min(kMaxLabelsOfParameter, labels.size() - first));
    section.Texts(n == 1 ? "LABELS" : fmt::format("LABELS{}", n), some);
  }
  if (numbers.frames > kMaxWord) {
    section.Real("LONG_FRAMES", static_cast<float>(numbers.frames));
  }
  section.Group("ANALOG");
  section.Word("USED", 0);
  section.Real("RATE", numbers.rate_hz);
  section.Group("FORCE_PLATFORM");
  section.Word("USED", 0);
  section.Group("TRIAL");
  section.Words("ACTUAL_START_FIELD", std::array<std::uint16_t, 2>{1, 0});
  section.Words("ACTUAL_END_FIELD", std::array{LowWord(numbers.frames), HighWord(numbers.frames)});
  section.Group("MANUFACTURER");
  section.Text("COMPANY", "motiondb");
  section.Text("SOFTWARE", "motiondb");
  return section;
}

void AppendHeader(const C3dNumbers& numbers, std::size_t data_block, std::string& file) {
  const std::size_t end = file.size() + kC3dBlock;
  file += static_cast<char>(kParameterBlock);
  file += '\x50';
  AppendWord16(LowWord(numbers.points), file);
  AppendWord16(0, file);  // analog samples of a frame
  AppendWord16(1, file);  // first frame
  AppendWord16(SaturatedWord(numbers.frames), file);
  AppendWord16(0, file);  // longest gap that was interpolated
  AppendReal(numbers.scale, file);
  AppendWord16(LowWord(data_block), file);
  AppendWord16(0, file);  // analog samples of a channel and frame
  AppendReal(numbers.rate_hz, file);
  file.resize(end, '\0');
}

void AppendPoint(const float* metres, std::string& file) {
  constexpr float kSeen = 0;  // residual
  constexpr float kMissing = -1;
  constexpr float kAboveOrigin_mm = 1e-6F;
  if (std::isnan(metres[0])) {
    for (const float value : {0.0F, 0.0F, 0.0F, kMissing}) AppendReal(value, file);
    return;
  }
  const bool at_origin = metres[0] == 0 && metres[1] == 0 && metres[2] == 0;
  AppendReal(kMillimetresPerMetre * metres[0], file);
  AppendReal(kMillimetresPerMetre * metres[1], file);
  AppendReal(at_origin ? kAboveOrigin_mm : kMillimetresPerMetre * metres[2], file);
  AppendReal(kSeen, file);
}

}  // namespace

absl::StatusOr<std::vector<std::string>> C3dLabels(const MarkerMotion& motion) {
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<std::string> labels, WritablePointNames("C3D", motion));
  std::unordered_set<std::string_view> seen;
  for (std::string& label : labels) {
    label.resize(text::TruncateUtf8(label, kMaxLabelBytes).size());
    label.resize(label.find_last_not_of(' ') + 1);
    if (seen.insert(label).second) continue;
    return InvalidArgument("C3D: two points have names with the same first {} bytes, '{}'",
                           kMaxLabelBytes, Shown(label));
  }
  return labels;
}

absl::StatusOr<std::string> WriteC3d(const MarkerMotion& motion) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<std::string> labels, C3dLabels(motion));
  const C3dNumbers numbers = NumbersOf(motion);
  if (numbers.points > kMaxC3dPoints) {
    return InvalidArgument("C3D: expected at most {} points, found {}", kMaxC3dPoints,
                           numbers.points);
  }
  if (numbers.frames > std::numeric_limits<std::int32_t>::max()) {
    return InvalidArgument("C3D: expected at most {} frames, found {}",
                           std::numeric_limits<std::int32_t>::max(), numbers.frames);
  }
  const std::size_t blocks = WriteParameters(numbers, labels, 0).Blocks();
  if (blocks > kMaxParameterBlocks) {
    return InvalidArgument(
        "C3D: the labels of {} points need {} bytes of parameters, expected at most {}: write "
        "fewer points or shorter names",
        numbers.points, blocks * kC3dBlock, kMaxParameterBlocks * kC3dBlock);
  }
  const std::size_t data_block = kParameterBlock + blocks;
  constexpr std::size_t kPointBytes = 16;
  const std::size_t size =
      (data_block - 1) * kC3dBlock + numbers.frames * numbers.points * kPointBytes;
  const std::size_t padded = (size + kC3dBlock - 1) / kC3dBlock * kC3dBlock;
  std::string file;
  file.reserve(padded);
  AppendHeader(numbers, data_block, file);
  WriteParameters(numbers, labels, data_block).AppendTo(file);
  const float* position = motion.positions_m.data();
  for (std::size_t point = 0; point < numbers.frames * numbers.points; ++point, position += 3) {
    AppendPoint(position, file);
  }
  file.resize(padded, '\0');
  return file;
}

}  // namespace motiondb::core
