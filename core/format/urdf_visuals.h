// Reads the visual shapes of a URDF link.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/link_visual.h"

namespace tinyxml2 {
class XMLElement;
}  // namespace tinyxml2

namespace motiondb::core {

class UrdfMaterials;

// Sizes of shapes and their distances from the link, along an axis.
inline constexpr double kMaxVisualLength_m = 100;
// Of all links of a file: a picture places each of them.
inline constexpr std::size_t kMaxVisuals = 1000;

// Returns the shapes of a <link>, in its frame (`joint` is not set): all of its <visual> elements,
// or none if one of them has no box, cylinder or sphere, because the others alone would mislead.
// INVALID_ARGUMENT names file, line and the expected content: numbers are finite, sizes above 0 and
// at most kMaxVisualLength_m, colours as in UrdfMaterials; with the `read_count` shapes of the
// links before, there are at most kMaxVisuals.
absl::StatusOr<std::vector<LinkVisual>> ReadLinkVisuals(std::string_view file_name,
                                                        const tinyxml2::XMLElement& link,
                                                        const UrdfMaterials& materials,
                                                        std::size_t read_count);

}  // namespace motiondb::core
