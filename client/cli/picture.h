// What is around the data in every picture of the command line: the file's head with the styles
// that all share, a heading and a legend. Sizes and places are pixels, y downwards. Pure functions.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::client {

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

}  // namespace motiondb::client
