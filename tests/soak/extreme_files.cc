#include "tests/soak/extreme_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

int Count(std::mt19937& random, double max) {
  return static_cast<int>(Magnitude(random, 1, std::max(1.0, max)));
}

std::string FrameTime(std::mt19937& random) {
  return fmt::format("{:.9g}", Magnitude(random, 1e-5, 2000));
}

// A figure with an unusual frame time.
std::string SlowFigure(std::mt19937& random, std::size_t max_bytes) {
  std::string text = WriteBvh(
      {.act = Act::kWalk, .frame_count = Count(random, static_cast<double>(max_bytes) / 500)});
  const std::size_t at = text.find("Frame Time:");
  const std::size_t end = text.find('\n', at);
  text.replace(at, end - at, "Frame Time: " + FrameTime(random));
  return text;
}

// A body of which only the root, or one angle, moves: two bytes per frame.
std::string TerseFigure(std::mt19937& random, std::size_t max_bytes) {
  std::string text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 90 0\nCHANNELS 1 Yposition\n";
  for (const char* const side : {"Left", "Right"}) {
    const double x = side[0] == 'L' ? 10 : -10;
    text += fmt::format(
        "JOINT {0}UpLeg\n{{\nOFFSET {1} 0 0\nCHANNELS 0\nJOINT {0}Leg\n{{\nOFFSET 0 -45 0\n"
        "CHANNELS 0\nJOINT {0}Foot\n{{\nOFFSET 0 -45 0\nCHANNELS 0\nEnd Site\n{{\n"
        "OFFSET 0 0 15\n}}\n}}\n}}\n}}\n",
        side, x);
  }
  const int frames = Count(random, static_cast<double>(max_bytes) / 2);
  text += fmt::format("}}\nMOTION\nFrames: {}\nFrame Time: {}\n", frames,
                      random() % 2 == 0 ? "0.0166667" : FrameTime(random));
  for (int f = 0; f < frames; ++f) text += f % 2 == 0 ? "0\n" : "1\n";
  return text;
}

// Claims more frames than the file has, or has very many joints.
std::string Claim(std::mt19937& random, std::size_t max_bytes) {
  std::string text = WriteBvh({.frame_count = 4});
  if (random() % 2 == 0) {
    const std::size_t at = text.find("Frames:");
    text.replace(at, text.find('\n', at) - at, fmt::format("Frames: {}", random() >> 1));
    text.append(max_bytes / 2, random() % 2 == 0 ? ' ' : '1');
    return text;
  }
  std::string joints = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n";
  const int count = Count(random, static_cast<double>(max_bytes) / 40);
  for (int j = 0; j < count; ++j) joints += "JOINT a\n{\nOFFSET 0 1 0\nCHANNELS 0\n}\n";
  return joints + "}\nMOTION\nFrames: 1\nFrame Time: 0.01\n\n";
}

std::string Trc(std::mt19937& random, std::size_t max_bytes) {
  const int markers = Count(random, static_cast<double>(max_bytes) / 8);
  const int frames = Count(random, static_cast<double>(max_bytes) / (4.0 * markers + 8));
  std::string text = fmt::format(
      "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
      "{}\t60\t{}\t{}\tm\nFrame#\tTime",
      Magnitude(random, 1e-3, 1e5), random() % 4 == 0 ? 1'000'000'000 : frames,
      random() % 4 == 0 ? 500'000'000 : markers);
  for (int m = 0; m < markers; ++m) text += m == 0 ? "\tLHip" : "\ta\t\t";
  text += "\n\tX1\n";
  for (int f = 0; f < frames; ++f) {
    text += fmt::format("{}\t{}", f + 1, f);
    text.append(3 * static_cast<std::size_t>(markers), '\t');
    text += '\n';
  }
  return text;
}

// A header, a parameter group with as many entries as fit, and points.
std::string C3d(std::mt19937& random, std::size_t max_bytes) {
  const auto put = [](std::string& bytes, std::size_t at, int word) {
    bytes[at] = static_cast<char>(word & 0xFF);
    bytes[at + 1] = static_cast<char>(word >> 8 & 0xFF);
  };
  const int parameter_blocks = Count(random, std::min(60'000.0, max_bytes / 1024.0));
  const int points = Count(random, 65'535);
  const int frames = Count(random, std::max(1.0, max_bytes / 2.0 / (8.0 * points)));
  std::string bytes(512 * static_cast<std::size_t>(1 + parameter_blocks), '\0');
  bytes[0] = 2;
  bytes[1] = 0x50;
  put(bytes, 2, points);
  put(bytes, 6, 1);
  put(bytes, 8, std::min(frames, 65'535));
  const float scale = 0.1F;
  const float rate = static_cast<float>(Magnitude(random, 1e-3, 1e5));
  std::memcpy(bytes.data() + 12, &scale, 4);
  put(bytes, 16, 2 + parameter_blocks);
  std::memcpy(bytes.data() + 20, &rate, 4);
  bytes[512 + 2] = static_cast<char>(std::min(parameter_blocks, 255));
  bytes[512 + 3] = 84;
  // Parameters of one byte each.
  const bool many = random() % 2 == 0;
  std::size_t at = 516;
  for (int n = 0; many && at + 16 < bytes.size(); ++n) {
    const std::string name = fmt::format("P{:06}", n);
    bytes[at] = static_cast<char>(name.size());
    bytes[at + 1] = 1;
    bytes.replace(at + 2, name.size(), name);
    put(bytes, at + 2 + name.size(), 5);
    bytes[at + 4 + name.size()] = 1;
    at += 7 + name.size();
  }
  bytes.append(8 * static_cast<std::size_t>(points) * static_cast<std::size_t>(frames), '\1');
  return bytes;
}

ExtremeFile Amc(std::mt19937& random, std::size_t max_bytes) {
  const int frames = Count(random, static_cast<double>(max_bytes) / 18);
  std::string text = fmt::format(":FULLY-SPECIFIED\n:DEGREES\n:SAMPLES-PER-SECOND {}\n",
                                 Magnitude(random, 1e-3, 1e5));
  for (int f = 1; f <= frames; ++f) text += fmt::format("{}\nroot 0 0 0 0 0 0\n", f);
  return {"a.amc", std::move(text), "a.asf",
          ":version 1.10\n:name a\n:units\n mass 1\n length 1\n angle deg\n:root\n order TX TY TZ "
          "RX RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 0\n:bonedata\n:hierarchy\n "
          "begin\n end\n"};
}

}  // namespace

double Magnitude(std::mt19937& random, double min, double max) {
  return min * std::pow(max / min, std::uniform_real_distribution<>(0, 1)(random));
}

ExtremeFile MakeExtremeFile(std::mt19937& random, std::size_t max_bytes) {
  switch (random() % 8) {
    case 0:
    case 1:
      return {"slow.bvh", SlowFigure(random, max_bytes), "", ""};
    case 2:
    case 3:
      return {"terse.bvh", TerseFigure(random, max_bytes), "", ""};
    case 4:
      return {"claim.bvh", Claim(random, max_bytes), "", ""};
    case 5:
      return {"names.trc", Trc(random, max_bytes), "", ""};
    case 6:
      return {"points.c3d", C3d(random, max_bytes), "", ""};
    default:
      return Amc(random, max_bytes);
  }
}

}  // namespace motiondb::tests
