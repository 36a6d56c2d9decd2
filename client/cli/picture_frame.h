// The rectangle of a picture that shows data: grid, ticks, captions and the frame around it. Sizes
// and places are pixels, y downwards. Plain values; pure functions.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::client {

struct PictureFrame {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

// Where an axis is named by a number (pixels).
struct Tick {
  double at = 0;
  std::string text;
};

// Units between ticks: 1, 2 or 5 times a power of ten, about 80 pixels.
double TickStep(double pixels_per_unit);

// Multiples of `step` from `low` to `high`.
std::vector<double> Ticks(double low, double high, double step);

// The same with their texts, as many decimals as the step needs; `pixel` says where a value is.
std::vector<Tick> LinearTicks(double low, double high, double step,
                              const std::function<double(double)>& pixel);

// Lines through the frame at the ticks.
std::string GridSvg(const PictureFrame& frame, const std::vector<Tick>& x_ticks,
                    const std::vector<Tick>& y_ticks);

// Numbers below a line at `bottom`, and left of the frame.
std::string XTicksSvg(double bottom, const std::vector<Tick>& ticks);
std::string YTicksSvg(const PictureFrame& frame, const std::vector<Tick>& ticks);

// What an axis shows: below its numbers, which are below a line at `bottom`, and at the picture's
// left edge.
std::string XCaptionSvg(const PictureFrame& frame, double bottom, std::string_view text);
std::string YCaptionSvg(const PictureFrame& frame, std::string_view text);

std::string FrameSvg(const PictureFrame& frame);

// Defines the inside of the frame as a clip path of that name.
std::string ClipPathSvg(std::string_view id, const PictureFrame& frame);

}  // namespace motiondb::client
