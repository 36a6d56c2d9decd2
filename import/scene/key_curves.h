// How values change between keys, where it is not linear.
#pragma once

#include <assimp/scene.h>

#include <unordered_map>
#include <vector>

namespace motiondb::importer {

enum class KeyInterpolation { kLinear, kStep, kCubicSpline };

// One component of a channel.
struct KeyCurve {
  KeyInterpolation interpolation = KeyInterpolation::kLinear;
  // Of a cubic spline, for each key: the tangent before it, then the one after it, in the order of
  // glTF (x, y, z, w) and per tick of the take.
  std::vector<float> tangents = {};
};

struct ChannelCurves {
  KeyCurve translation;
  KeyCurve rotation;
  KeyCurve scale;
};

// Of channels with a component that is not linear.
using SceneCurves = std::unordered_map<const aiNodeAnim*, ChannelCurves>;

}  // namespace motiondb::importer
