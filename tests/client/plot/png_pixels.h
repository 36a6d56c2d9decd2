// Decodes a PNG file.
#pragma once

#include <cairo.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <string_view>

namespace motiondb::tests {

class PngPixels {
 public:
  // Fails if it is no PNG file.
  explicit PngPixels(const std::string& bytes) {
    std::string_view rest = bytes;
    surface_ = cairo_image_surface_create_from_png_stream(
        [](void* closure, unsigned char* data, unsigned length) {
          auto& left = *static_cast<std::string_view*>(closure);
          if (left.size() < length) return CAIRO_STATUS_READ_ERROR;
          std::memcpy(data, left.data(), length);
          left.remove_prefix(length);
          return CAIRO_STATUS_SUCCESS;
        },
        &rest);
    REQUIRE(cairo_surface_status(surface_) == CAIRO_STATUS_SUCCESS);
  }
  ~PngPixels() { cairo_surface_destroy(surface_); }
  PngPixels(const PngPixels&) = delete;
  PngPixels& operator=(const PngPixels&) = delete;

  int width() const { return cairo_image_surface_get_width(surface_); }
  int height() const { return cairo_image_surface_get_height(surface_); }

  // 0xRRGGBB.
  std::uint32_t At(int x, int y) const {
    std::uint32_t pixel = 0;
    std::memcpy(&pixel,
                cairo_image_surface_get_data(surface_) +
                    y * cairo_image_surface_get_stride(surface_) + 4 * x,
                4);
    return pixel & 0xFFFFFF;
  }

  int ColourCount() const {
    std::set<std::uint32_t> colours;
    for (int y = 0; y < height(); ++y) {
      for (int x = 0; x < width(); ++x) colours.insert(At(x, y));
    }
    return static_cast<int>(colours.size());
  }

 private:
  cairo_surface_t* surface_;
};

}  // namespace motiondb::tests
