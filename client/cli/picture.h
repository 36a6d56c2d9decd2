// What pictures of the command line are made of: pieces of SVG, what is around the data, and axes.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::client {

// Pieces of an SVG file: escaped text, numbers that are always written alike, and elements, whose
// `style` is a class of the file's style sheet. Coordinates and sizes are pixels, y downwards. Pure
// functions.

// Text for an element or an attribute: characters that mean something to XML are escaped, those
// that XML does not allow are left out, and bytes that are not UTF-8 become '?'.
std::string SvgText(std::string_view text);

// A coordinate in pixels, with two decimals and never "-0.00"; 0 for what is not finite.
std::string SvgNumber(double value);

std::string SvgLine(std::string_view style, double x1, double y1, double x2, double y2);
std::string SvgCircle(std::string_view style, double x, double y, double radius);
std::string SvgRectangle(std::string_view style, double left, double top, double width,
                         double height);

// A line of text on a base line at y; `attributes` are written as they are.
std::string SvgLabel(std::string_view style, double x, double y, std::string_view text,
                     std::string_view attributes = "");

// What is around the data in every picture of the command line: the file's head with the styles
// that all share, a heading and a legend. Sizes and places are pixels, y downwards. Pure functions.

// Opens an SVG file. `style` is added to the styles title, line, tick, grid and frame. The file
// ends with "</svg>\n".
std::string PictureHead(double width, double height, std::string_view title,
                        std::string_view style);

std::string BackgroundSvg(double width, double height);

// As much of a line of the heading as a width has room for.
std::string FittingText(const std::string& text, double width);

// A title and lines below it, and how high they are with the gap below them.
std::string HeadingSvg(double left, double width, const std::string& title,
                       const std::vector<std::string>& lines);
double HeadingHeight(std::size_t lines);

// A name, and what it looks like in the picture, drawn about (x, y) and to the right of it.
struct LegendEntry {
  std::string name;
  std::function<std::string(double x, double y)> sample;
};

struct Legend {
  std::string svg;
  double last_y = 0;  // of the last row
};

// Entries side by side, so far apart, the first row at y, in as many rows as they need.
Legend LegendSvg(const std::vector<LegendEntry>& entries, double left, double right, double y,
                 double between = 22);

// The rectangle of a picture that shows data: grid, ticks, captions and the frame around it. Sizes
// and places are pixels, y downwards. Plain values; pure functions.
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

// An axis for log probabilities, which lie between -1 and many thousands below 0 in one picture: at
// small values nearly linear, beyond about -10 logarithmic (an inverse hyperbolic sine). Plain
// value; pure functions.
class LogProbabilityAxis {
 public:
  // An axis without values, from 0 to -10.
  LogProbabilityAxis();

  // Widens the axis to hold a value, down to kLowest; one that is not finite is passed over.
  void Add(double value);

  // Where a value is: 0 at the upper end, 1 at the lower end.
  double Fraction(double value) const;

  // Whether a value lies below the axis.
  bool IsBelow(double value) const { return value < kLowest; }

  // 0 and powers of ten, above and below, from the top. Near 0 there are only those that are
  // `least` of the axis away from each other.
  std::vector<double> Ticks(double least) const;

  // "0", "-10", "-10000", "-1e5".
  static std::string TickText(double value);

 private:
  static constexpr double kLowest = -1e6;

  double high_ = 0;
  double low_ = -10;
};

}  // namespace motiondb::client
