// Builds small animated scenes as files.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace motiondb::tests {

// A glTF 2.0 file in text form with its buffers in base64. Add nodes to `json["nodes"]`; node 0 is
// the scene's root.
class GltfFile {
 public:
  GltfFile();

  // Adds an accessor of floats; `width`: 1, 3 or 4 numbers for each element. Returns its index.
  int AddFloats(const std::vector<float>& values, int width);
  // Adds an animation without channels. Returns its index.
  int AddTake(std::string_view name);
  // Adds an accessor of normalized int16. Returns its index.
  int AddShorts(const std::vector<float>& values, int width);
  // Adds a channel; `path`: "translation", "rotation" or "scale". `values`: 3 or 4 for each time,
  // with CUBICSPLINE three times as many.
  void AddChannel(int take, int node, std::string_view path, const std::vector<float>& times_s,
                  const std::vector<float>& values, std::string_view interpolation = "LINEAR");
  std::string Text() const { return json.dump(); }
  std::string Binary() const;  // GLB

  nlohmann::json json;

 private:
  int AddAccessor(const std::string& bytes, int component, std::size_t count, int width);
};

// Hips (1 m above the floor) and a head, 0.5 m higher; y up. The hips turn about x, from 0 by 0.1
// rad in each of `frames` frames at 30 Hz.
GltfFile NoddingFigure(int frames);

// FBX in text form.
struct FbxModel {
  std::string name;
  int parent = -1;  // index
  std::map<std::string, std::array<double, 3>> properties;
};

struct FbxCurves {
  int model = 0;
  std::string property;  // "Lcl Rotation"
  // For each axis, time in s and value of its keys.
  std::array<std::vector<std::pair<double, double>>, 3> keys;
};

struct FbxFile {
  std::vector<FbxModel> models;
  std::vector<FbxCurves> curves;
  double unit_cm = 1;
  int up_axis = 1;                             // 0 x, 1 y, 2 z
  int time_mode = 6;                           // 30 Hz
  std::pair<double, double> range_s = {0, 0};  // of the take; 0, 0: not stated
  std::string Text() const;
};

// A Collada file with these <node> elements. Node "Hips" has a <rotate sid="turn">, whose angle is
// animated by keys at `times`.
struct ColladaFile {
  std::string asset = R"(<unit meter="0.01"/><up_axis>Z_UP</up_axis>)";
  std::string nodes =
      R"(<node id="Hips" type="JOINT"><translate>0 0 100</translate><rotate sid="turn">1 0 0 0)"
      R"(</rotate><node id="Head" type="JOINT"><translate>0 0 50</translate></node></node>)";
  std::string libraries;
  std::string times = "0 0.04 0.08";
  std::string degrees = "0 10 20";
  std::string Text() const;
};

}  // namespace motiondb::tests
