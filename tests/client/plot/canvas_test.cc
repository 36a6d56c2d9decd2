#include "client/cli/plot/canvas.h"

#include <cairo.h>
#include <tinyxml2.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/client/plot/png_pixels.h"
#include "tests/client/plot/svg_elements.h"

namespace motiondb::tests::canvas_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;

// A picture with every shape.
Canvas EveryShape(const std::string& text = "text") {
  Canvas canvas;
  canvas.SetTitle(text);
  canvas.SetSize(200, 100);
  canvas.AddStyle("red", {.fill = "#f00"});
  canvas.AddStyle("blue-line", {.fill = "none", .stroke = "#00f", .stroke_width = 2});
  canvas.AddStyle("dots", {.fill = "#0072b2", .pattern = FillPattern::kDots});
  canvas.AddStyle("stripes", {.fill = "#0072b2", .pattern = FillPattern::kStripes});
  canvas.AddStyle("hatched", {.fill = "#777", .pattern = FillPattern::kHatching});
  canvas.AddStyle("unused", {.fill = "#123456"});
  canvas.BeginGroup(PictureFrame{0, 0, 200, 100}).tooltip = text;
  canvas.Line("blue-line", 0, 0, 10, 10).stroke_width = 3;
  canvas.Circle("red", 20, 20, 5).tooltip = text;
  canvas.Ellipse("red", {{50, 50}, 10, 5, 0.5});
  canvas.Rectangle("dots", {60, 60, 20, 20});
  canvas.Rectangle("stripes", {80, 60, 20, 20});
  canvas.Rectangle("hatched", {100, 60, 20, 20});
  canvas.Polyline("blue-line", {{0, 50}, {10, 60}, {20, 50}});
  canvas.Polygon("red", {{150, 10}, {160, 10}, {155, 20}});
  canvas.Path("blue-line", {{{{0, 80}, {10, 80}, {10, 90}}, true}, {{{20, 80}, {30, 90}}, false}});
  canvas.Sector("red", {{180, 80}, 10, 0, 1});
  canvas.Label("title", 5, 40, text);
  canvas.VerticalLabel("line", 195, 50, text);
  canvas.HoverArea({0, 0, 10, 10}, text);
  canvas.EndGroup();
  return canvas;
}

TEST_CASE("Canvas: SVG has an element for each shape", "[client][cli]") {
  const std::string svg = SvgOf(EveryShape());
  auto elements = ElementsInGroups(svg);
  CHECK(elements["line.blue-line"] == 1);
  CHECK(elements["circle.red"] == 1);
  CHECK(elements["ellipse.red"] == 1);
  CHECK(elements["rect.dots"] == 1);
  CHECK(elements["rect.hatched"] == 1);
  CHECK(elements["polyline.blue-line"] == 1);
  CHECK(elements["polygon.red"] == 1);
  CHECK(elements["path.blue-line"] == 1);
  CHECK(elements["path.red"] == 1);
  CHECK(elements["text.title"] == 1);
  CHECK(elements["rect.hover"] == 1);
  CHECK_THAT(svg, Contains("d=\"M0.00 80.00H10.00V90.00ZM20.00 80.00L30.00 90.00\"") &&
                      Contains("stroke-width:3.00") && !Contains(".unused") &&
                      Contains("id=\"dots-0072b2\"") && Contains("id=\"hatching-777\""));
  CHECK(svg == SvgOf(EveryShape()));
}

TEST_CASE("Canvas: names are escaped", "[client][cli]") {
  const std::string hostile = "<script>alert('&\"')</script>\x01\xff]]>";
  const std::string svg = SvgOf(EveryShape(hostile));
  ElementsInGroups(svg);  // well-formed
  CHECK_THAT(svg, !Contains("<script") && !Contains("]]>"));
  tinyxml2::XMLDocument document;
  REQUIRE(document.Parse(svg.c_str()) == tinyxml2::XML_SUCCESS);
  CHECK(std::string(document.RootElement()->FirstChildElement("title")->GetText()) ==
        "<script>alert('&\"')</script>\xEF\xBF\xBD\xEF\xBF\xBD]]>");
  REQUIRE(PngOf(EveryShape(hostile)).ok());
}

TEST_CASE("Canvas: PNG has the size, the colours and the places of the shapes", "[client][cli]") {
  const auto png = PngOf(EveryShape());
  REQUIRE(png.ok());
  const PngPixels pixels(*png);
  REQUIRE(pixels.width() == 200);
  REQUIRE(pixels.height() == 100);
  CHECK(pixels.At(20, 20) == 0xFF0000u);
  CHECK(pixels.At(50, 50) == 0xFF0000u);
  CHECK(pixels.At(155, 13) == 0xFF0000u);
  CHECK(pixels.At(186, 77) == 0xFF0000u);  // in the sector
  CHECK(pixels.At(186, 83) == 0xFFFFFFu);  // outside of it
  CHECK(pixels.At(5, 5) == 0x0000FFu);     // the line
  CHECK(pixels.At(130, 40) == 0xFFFFFFu);  // the background
  CHECK(pixels.At(60, 60) == 0x0072B2u);   // between the dots
  // Text, in black; its width depends on the font.
  int dark = 0;
  for (int x = 5; x < 45; ++x) {
    for (int y = 25; y < 45; ++y) dark += (pixels.At(x, y) & 0xFF) < 0x60;
  }
  CHECK(dark > 20);
  CHECK(*png == *PngOf(EveryShape()));
}

TEST_CASE("Canvas: a frame hides what is outside", "[client][cli]") {
  Canvas canvas;
  canvas.SetSize(40, 20);
  canvas.AddStyle("red", {.fill = "#f00"});
  canvas.BeginGroup(PictureFrame{0, 0, 20, 20});
  canvas.Rectangle("red", {10, 0, 20, 20});
  canvas.EndGroup();
  canvas.Rectangle("red", {35, 0, 5, 20});
  const PngPixels pixels(*PngOf(canvas));
  CHECK(pixels.At(15, 10) == 0xFF0000u);
  CHECK(pixels.At(25, 10) == 0xFFFFFFu);
  CHECK(pixels.At(37, 10) == 0xFF0000u);
  CHECK_THAT(SvgOf(canvas), Contains("clip-path=\"url(#clip-1)\""));
}

TEST_CASE("Canvas: values that are not finite and huge sizes are harmless", "[client][cli]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Canvas canvas;
  canvas.SetSize(50, 50);
  canvas.Line("grid", nan, 0, 1e300, -1e300);
  canvas.Circle("grid", nan, nan, nan);
  canvas.Ellipse("grid", {{0, 0}, 0, 0, nan});
  canvas.Polyline("grid", {});
  canvas.Polygon("grid", {});
  canvas.Path("grid", {{}, {{}, true}});
  canvas.Label("line", nan, nan, "");
  CHECK(PngOf(canvas).ok());
  CHECK_THAT(SvgOf(canvas), !Contains("nan") && !Contains("inf"));
  canvas.SetSize(1e6, 1e6);
  CHECK(PngOf(canvas).status().code() == absl::StatusCode::kResourceExhausted);
  canvas.SetSize(0, nan);
  CHECK(!PngOf(canvas).ok());
}

TEST_CASE("Canvas: later rules override earlier ones", "[client][cli]") {
  Canvas canvas;
  canvas.AddStyle("a", {.fill = "#f00", .stroke_width = 1});
  canvas.AddStyle("b", {.stroke_width = 2});
  const ShapeStyle style = canvas.StyleOf(canvas.Circle("b a", 0, 0, 1));
  CHECK(style.fill == "#f00");
  CHECK(style.stroke_width == 2);
  CHECK(canvas.StyleOf(canvas.Circle("ab", 0, 0, 1)).fill.empty());
}

}  // namespace
}  // namespace motiondb::tests::canvas_test
