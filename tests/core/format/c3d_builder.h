// Builds small C3D files for each type of processor.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/format/c3d_file.h"

namespace motiondb::tests {

struct C3dPoint {
  float x = 0;
  float y = 0;
  float z = 0;
  int residual = 0;  // negative: the point is invalid
};

// Set the fields of interest, then call Build(). Frames are numbered from `first_frame`.
struct C3dBuilder {
  core::C3dProcessor processor = core::C3dProcessor::kIntel;
  bool real = true;
  float scale = 0.1F;  // of integer data; `real` sets the sign
  float rate_hz = 100;
  int first_frame = 1;
  std::optional<float> scale_parameter;  // POINT:SCALE, if it differs from the header
  std::optional<float> rate_parameter;   // POINT:RATE
  int analog_per_frame = 0;              // samples
  int analog_ratio = 1;                  // samples of a channel, in the header
  int analog_used = 0;                   // channels; 0: no parameter
  int force_platforms = 0;
  bool events = false;
  std::string units = "mm";         // empty: no parameter
  std::string y_screen;             // empty: no parameter
  std::vector<std::string> labels;  // in LABELS, LABELS2 ... of 255 each
  std::vector<std::string> labels2;
  std::vector<std::string> angles;
  bool long_count = false;   // frame count in TRIAL, as in files with more than 65535 frames
  bool long_frames = false;  // frame count in POINT:LONG_FRAMES
  int parameter_block = 2;   // the first is 1
  bool data_first = false;   // the frames before the parameters
  bool groups_last = false;  // the names of groups after their parameters
  std::vector<std::vector<C3dPoint>> frames;

  std::string Build() const {
    constexpr std::size_t kBlock = core::kC3dBlock;
    std::string parameters = Parameters();
    const std::size_t blocks = (parameters.size() + kBlock - 1) / kBlock;
    parameters.resize(blocks * kBlock);
    parameters[2] = static_cast<char>(blocks);
    std::string data = Data();
    std::size_t parameter_start = static_cast<std::size_t>(parameter_block) * kBlock - kBlock;
    std::size_t data_start = parameter_start + parameters.size();
    if (data_first) {
      data_start = kBlock;
      parameter_start = (kBlock + data.size() + kBlock - 1) / kBlock * kBlock;
    }
    std::string file = Header(parameter_start / kBlock + 1, data_start / kBlock + 1);
    file.resize(std::min(parameter_start, data_start));
    file += data_first ? data : parameters;
    file.resize(std::max(parameter_start, data_start));
    file += data_first ? parameters : data;
    return file;
  }

 private:
  std::string Header(std::size_t parameters, std::size_t data) const {
    const bool is_long = long_count || long_frames;
    std::string header{static_cast<char>(parameters), '\x50'};
    header += Word(PointCount());
    header += Word(analog_per_frame);
    header += Word(first_frame);
    header += Word(is_long ? 65535 : LastFrame());
    header += Word(10);
    header += Real(real ? -scale : scale);
    header += Word(static_cast<int>(data));
    header += Word(analog_ratio);
    header += Real(rate_hz);
    if (events) {
      header.resize(298);
      header += Word(12345) + Word(18);  // the key of labels of four characters; their count
      header.resize(core::kC3dBlock, '\x55');
    }
    header.resize(core::kC3dBlock);
    return header;
  }

  std::string Data() const {
    std::string data;
    for (const auto& frame : frames) {
      for (const C3dPoint& point : frame) {
        for (const float value : {point.x, point.y, point.z}) {
          data += real ? Real(value) : Word(static_cast<int>(std::lround(value / scale)));
        }
        data += real ? Real(static_cast<float>(point.residual)) : Word(point.residual);
      }
      for (int i = 0; i < analog_per_frame; ++i) data += real ? Real(1e30F) : Word(12345);
    }
    return data;
  }

  int PointCount() const { return static_cast<int>(frames.empty() ? 0 : frames[0].size()); }
  int LastFrame() const { return first_frame + static_cast<int>(frames.size()) - 1; }

  std::string Word(int value) const {
    const char low = static_cast<char>(value & 0xFF);
    const char high = static_cast<char>((value >> 8) & 0xFF);
    return processor == core::C3dProcessor::kMips ? std::string{high, low} : std::string{low, high};
  }

  std::string Real(float value) const {
    if (processor == core::C3dProcessor::kDec) value *= 4;
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const int low = static_cast<int>(bits & 0xFFFF);
    const int high = static_cast<int>(bits >> 16);
    return processor == core::C3dProcessor::kIntel ? Word(low) + Word(high)
                                                   : Word(high) + Word(low);
  }

  std::string Group(int number, std::string_view name) const {
    return static_cast<char>(name.size()) + std::string(1, static_cast<char>(-number)) +
           std::string(name) + Word(3) + '\0';
  }

  std::string Parameter(int group, std::string_view name, int type,
                        const std::vector<int>& dimensions, const std::string& data) const {
    std::string contents(1, static_cast<char>(type));
    contents += static_cast<char>(dimensions.size());
    for (const int dimension : dimensions) contents += static_cast<char>(dimension);
    contents += data + '\0';
    return static_cast<char>(name.size()) + std::string(1, static_cast<char>(group)) +
           std::string(name) + Word(static_cast<int>(contents.size()) + 2) + contents;
  }

  std::string Texts(std::string_view name, const std::vector<std::string>& texts) const {
    std::size_t length = 0;
    for (const std::string& text : texts) length = std::max(length, text.size());
    std::string data;
    for (std::string text : texts) {
      text.resize(length, ' ');
      data += text;
    }
    return Parameter(1, name, -1, {static_cast<int>(length), static_cast<int>(texts.size())}, data);
  }

  std::string Parameters() const {
    const std::string groups = Group(1, "POINT") + Group(2, "TRIAL") + Group(3, "ANALOG") +
                               Group(4, "FORCE_PLATFORM") + Group(5, "EVENT");
    std::string section{'\x01', '\x50', '\0', static_cast<char>(processor)};
    if (!groups_last) section += groups;
    section += Parameter(1, "USED", 2, {}, Word(PointCount()));
    section += Parameter(1, "SCALE", 4, {}, Real(scale_parameter.value_or(real ? -scale : scale)));
    section += Parameter(1, "rate", 4, {}, Real(rate_parameter.value_or(rate_hz)));
    if (!units.empty()) section += Texts("UNITS", {units});
    if (!y_screen.empty()) section += Texts("Y_SCREEN", {y_screen});
    for (std::size_t first = 0; first < labels.size(); first += 255) {
      const auto begin = labels.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end = labels.end() - begin > 255 ? begin + 255 : labels.end();
      section +=
          Texts(first == 0 ? "LABELS" : "LABELS" + std::to_string(first / 255 + 1), {begin, end});
    }
    if (!labels2.empty()) section += Texts("LABELS2", labels2);
    if (!angles.empty()) section += Texts("ANGLES", angles);
    if (long_frames) {
      section += Parameter(1, "LONG_FRAMES", 4, {}, Real(static_cast<float>(frames.size())));
    }
    if (long_count) {
      section += Parameter(2, "ACTUAL_START_FIELD", 2, {2}, Words32(first_frame));
      section += Parameter(2, "ACTUAL_END_FIELD", 2, {2}, Words32(LastFrame()));
    }
    if (analog_used > 0) section += Parameter(3, "USED", 2, {}, Word(analog_used));
    if (force_platforms > 0) section += Parameter(4, "USED", 2, {}, Word(force_platforms));
    if (events) {
      section += Parameter(5, "USED", 2, {}, Word(1));
      section += Parameter(5, "LABELS", -1, {4, 1}, "Foot");
      section += Parameter(5, "TIMES", 4, {2, 1}, Real(0) + Real(0.5F));
    }
    if (groups_last) section += groups;
    return section + '\0';
  }

  std::string Words32(int value) const { return Word(value) + Word(value >> 16); }
};

}  // namespace motiondb::tests
