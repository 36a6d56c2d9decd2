// Builds small C3D files for each type of processor.
#pragma once

#include <bit>
#include <cstdint>
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
  int analog_per_frame = 0;
  std::string units = "mm";  // empty: no parameter
  std::string y_screen;      // empty: no parameter
  std::vector<std::string> labels;
  std::vector<std::string> labels2;
  std::vector<std::string> angles;
  bool long_count = false;  // frame count in TRIAL, as in files with more than 65535 frames
  std::vector<std::vector<C3dPoint>> frames;

  std::string Build() const {
    constexpr std::size_t kBlock = core::kC3dBlock;
    std::string parameters = Parameters();
    const std::size_t blocks = (parameters.size() + kBlock - 1) / kBlock;
    parameters.resize(blocks * kBlock);
    parameters[2] = static_cast<char>(blocks);
    const std::size_t data_block = 2 + blocks;
    const int last = first_frame + static_cast<int>(frames.size()) - 1;

    std::string file = "\x02\x50";
    file += Word(static_cast<int>(frames.empty() ? 0 : frames[0].size()));
    file += Word(analog_per_frame);
    file += Word(first_frame);
    file += Word(long_count ? 65535 : last);
    file += Word(10);
    file += Real(real ? -scale : scale);
    file += Word(static_cast<int>(data_block));
    file += Word(1);
    file += Real(rate_hz);
    file.resize(kBlock);
    file += parameters;
    for (const auto& frame : frames) {
      for (const C3dPoint& point : frame) {
        for (const float value : {point.x, point.y, point.z}) {
          file += real ? Real(value) : Word(static_cast<int>(std::lround(value / scale)));
        }
        file += real ? Real(static_cast<float>(point.residual)) : Word(point.residual);
      }
      for (int i = 0; i < analog_per_frame; ++i) file += real ? Real(1e30F) : Word(12345);
    }
    return file;
  }

 private:
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

  std::string Parameter(int group, std::string_view name, int type, std::vector<int> dimensions,
                        const std::string& data) const {
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
    std::string section{'\x01', '\x50', '\0', static_cast<char>(processor)};
    section += Group(1, "POINT") + Group(2, "TRIAL");
    section +=
        Parameter(1, "USED", 2, {}, Word(static_cast<int>(frames.empty() ? 0 : frames[0].size())));
    section += Parameter(1, "SCALE", 4, {}, Real(real ? -scale : scale));
    section += Parameter(1, "rate", 4, {}, Real(rate_hz));
    if (!units.empty()) section += Texts("UNITS", {units});
    if (!y_screen.empty()) section += Texts("Y_SCREEN", {y_screen});
    section += Texts("LABELS", labels);
    if (!labels2.empty()) section += Texts("LABELS2", labels2);
    if (!angles.empty()) section += Texts("ANGLES", angles);
    if (long_count) {
      const int last = first_frame + static_cast<int>(frames.size()) - 1;
      section += Parameter(2, "ACTUAL_START_FIELD", 2, {2}, Word(first_frame) + Word(0));
      section += Parameter(2, "ACTUAL_END_FIELD", 2, {2}, Word(last) + Word(last >> 16));
    }
    return section;
  }
};

}  // namespace motiondb::tests
