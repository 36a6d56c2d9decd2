#include "tests/import/scene/scene_files.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace motiondb::tests {

namespace {

std::string BytesOf(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string Base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

std::string FromBase64(std::string_view text) {
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | static_cast<std::uint32_t>(kDigits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 255);
  }
  return bytes;
}

constexpr std::string_view kDataUri = "data:application/octet-stream;base64,";

std::string LittleEndian(std::size_t number) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 255);
  return bytes;
}

}  // namespace

GltfFile::GltfFile() {
  json = {{"asset", {{"version", "2.0"}}},          {"scene", 0},
          {"scenes", {{{"nodes", {0}}}}},           {"nodes", nlohmann::json::array()},
          {"animations", nlohmann::json::array()},  {"accessors", nlohmann::json::array()},
          {"bufferViews", nlohmann::json::array()}, {"buffers", nlohmann::json::array()}};
}

int GltfFile::AddFloats(const std::vector<float>& values, int width) {
  return AddAccessor(BytesOf(values), 5126, values.size() / static_cast<std::size_t>(width), width);
}

int GltfFile::AddShorts(const std::vector<float>& values, int width) {
  std::string bytes;
  for (const float value : values) {
    const auto number = static_cast<std::int16_t>(std::lround(value * 32767));
    bytes += {static_cast<char>(number & 255), static_cast<char>(number >> 8)};
  }
  const int index =
      AddAccessor(bytes, 5122, values.size() / static_cast<std::size_t>(width), width);
  json["accessors"].back()["normalized"] = true;
  return index;
}

int GltfFile::AddAccessor(const std::string& bytes, int component, std::size_t count, int width) {
  const int index = static_cast<int>(json["accessors"].size());
  json["buffers"].push_back(
      {{"byteLength", bytes.size()}, {"uri", std::string(kDataUri) + Base64(bytes)}});
  json["bufferViews"].push_back({{"buffer", index}, {"byteLength", bytes.size()}});
  json["accessors"].push_back({{"bufferView", index},
                               {"componentType", component},
                               {"count", count},
                               {"type", width == 1   ? "SCALAR"
                                        : width == 3 ? "VEC3"
                                                     : "VEC4"}});
  return index;
}

int GltfFile::AddTake(std::string_view name) {
  json["animations"].push_back({{"name", name},
                                {"samplers", nlohmann::json::array()},
                                {"channels", nlohmann::json::array()}});
  return static_cast<int>(json["animations"].size()) - 1;
}

void GltfFile::AddChannel(int take, int node, std::string_view path,
                          const std::vector<float>& times_s, const std::vector<float>& values,
                          std::string_view interpolation) {
  nlohmann::json& animation = json["animations"][static_cast<std::size_t>(take)];
  const std::size_t sampler = animation["samplers"].size();
  animation["samplers"].push_back({{"input", AddFloats(times_s, 1)},
                                   {"output", AddFloats(values, path == "rotation" ? 4 : 3)},
                                   {"interpolation", interpolation}});
  animation["channels"].push_back(
      {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
}

std::string GltfFile::Binary() const {
  nlohmann::json whole = json;
  std::string bytes;
  for (std::size_t i = 0; i < whole["buffers"].size(); ++i) {
    const std::string uri = whole["buffers"][i]["uri"];
    whole["bufferViews"][i]["buffer"] = 0;
    whole["bufferViews"][i]["byteOffset"] = bytes.size();
    bytes += FromBase64(std::string_view(uri).substr(kDataUri.size()));
  }
  whole["buffers"] = {{{"byteLength", bytes.size()}}};
  std::string text = whole.dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  const std::string chunks = LittleEndian(text.size()) + "JSON" + text +
                             LittleEndian(bytes.size()) + std::string("BIN\0", 4) + bytes;
  return "glTF" + LittleEndian(2) + LittleEndian(12 + chunks.size()) + chunks;
}

GltfFile NoddingFigure(int frames) {
  GltfFile file;
  file.json["nodes"] = {{{"name", "Hips"}, {"translation", {0, 1, 0}}, {"children", {1}}},
                        {{"name", "Head"}, {"translation", {0, 0.5, 0}}}};
  std::vector<float> times;
  std::vector<float> turns;
  for (int i = 0; i < frames; ++i) {
    times.push_back(static_cast<float>(i) / 30);
    const float half = 0.05F * static_cast<float>(i);
    turns.insert(turns.end(), {std::sin(half), 0, 0, std::cos(half)});
  }
  file.AddChannel(file.AddTake("Nod"), 0, "rotation", times, turns);
  return file;
}

namespace {

std::string FbxVector(std::string_view name, const std::array<double, 3>& v) {
  return fmt::format("P: \"{}\", \"Vector3D\", \"Vector\", \"\",{},{},{}\n", name, v[0], v[1],
                     v[2]);
}

std::string FbxNumber(std::string_view name, double value) {
  return fmt::format("P: \"{}\", \"double\", \"Number\", \"\",{}\n", name, value);
}

std::string FbxInteger(std::string_view name, int value) {
  return fmt::format("P: \"{}\", \"int\", \"Integer\", \"\",{}\n", name, value);
}

long long FbxTicks(double seconds) {
  constexpr double kTicksPerSecond = 46186158000;
  return std::llround(seconds * kTicksPerSecond);
}

std::string FbxTime(std::string_view name, double seconds) {
  return fmt::format("P: \"{}\", \"KTime\", \"Time\", \"\",{}\n", name, FbxTicks(seconds));
}

std::string FbxCurve(int id, const std::vector<std::pair<double, double>>& keys) {
  std::string times;
  std::string values;
  for (const auto& [time, value] : keys) {
    const char* const comma = times.empty() ? "" : ",";
    times += fmt::format("{}{}", comma, FbxTicks(time));
    values += fmt::format("{}{}", comma, value);
  }
  return fmt::format(
      "AnimationCurve: {0}, \"AnimCurve::\", \"\" {{\nDefault: 0\nKeyVer: 4008\n"
      "KeyTime: *{1} {{\na: {2}\n}}\nKeyValueFloat: *{1} {{\na: {3}\n}}\n"
      "KeyAttrFlags: *1 {{\na: 24836\n}}\nKeyAttrDataFloat: *4 {{\na: 0,0,0,0\n}}\n"
      "KeyAttrRefCount: *1 {{\na: {1}\n}}\n}}\n",
      id, keys.size(), times, values);
}

}  // namespace

std::string FbxFile::Text() const {
  constexpr int kFirstModel = 1'000'000;
  constexpr int kFirstCurve = 2'000'000;
  std::string objects;
  std::string connections = "C: \"OO\",2,1\n";
  for (std::size_t m = 0; m < models.size(); ++m) {
    const int id = kFirstModel + static_cast<int>(m);
    objects +=
        fmt::format("Model: {}, \"Model::{}\", \"LimbNode\" {{\nVersion: 232\nProperties70:  {{\n",
                    id, models[m].name);
    for (const auto& [name, value] : models[m].properties) objects += FbxVector(name, value);
    objects += "}\n}\n";
    connections += fmt::format("C: \"OO\",{},{}\n", id,
                               models[m].parent < 0 ? 0 : kFirstModel + models[m].parent);
  }
  objects += "AnimationStack: 1, \"AnimStack::Take\", \"\" {\nProperties70:  {\n" +
             FbxTime("LocalStart", range_s.first) + FbxTime("LocalStop", range_s.second) + "}\n}\n";
  objects += "AnimationLayer: 2, \"AnimLayer::Base\", \"\" {\n}\n";
  int id = kFirstCurve;
  for (const FbxCurves& moved : curves) {
    const int curve_node = id++;
    objects +=
        fmt::format("AnimationCurveNode: {}, \"AnimCurveNode::T\", \"\" {{\n}}\n", curve_node);
    connections += fmt::format("C: \"OO\",{0},2\nC: \"OP\",{0},{1}, \"{2}\"\n", curve_node,
                               kFirstModel + moved.model, moved.property);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (moved.keys[axis].empty()) continue;
      objects += FbxCurve(id, moved.keys[axis]);
      connections += fmt::format("C: \"OP\",{},{}, \"d|{}\"\n", id, curve_node, "XYZ"[axis]);
      ++id;
    }
  }
  return "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\nFBXHeaderVersion: 1003\n"
         "FBXVersion: 7400\n}\nGlobalSettings:  {\nVersion: 1000\nProperties70:  {\n" +
         FbxInteger("UpAxis", up_axis) + FbxInteger("UpAxisSign", 1) +
         FbxNumber("UnitScaleFactor", unit_cm) + FbxInteger("TimeMode", time_mode) +
         "}\n}\nObjects:  {\n" + objects + "}\nConnections:  {\n" + connections + "}\n";
}

std::string ColladaFile::Text() const {
  const auto source = [](std::string_view id, std::string_view numbers, std::string_view name) {
    std::size_t count = 1;
    for (const char c : numbers) count += c == ' ' ? 1 : 0;
    return fmt::format(
        R"(<source id="{0}"><float_array id="{0}a" count="{1}">{2}</float_array>)"
        R"(<technique_common><accessor source="#{0}a" count="{1}" stride="1"><param name="{3}")"
        R"( type="float"/></accessor></technique_common></source>)",
        id, count, numbers, name);
  };
  return fmt::format(
      R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema")"
      R"( version="1.4.1"><asset>{}</asset><library_animations><animation id="Turn">{}{})"
      R"(<sampler id="s"><input semantic="INPUT" source="#t"/><input semantic="OUTPUT" source="#v")"
      R"(/></sampler><channel source="#s" target="Hips/turn.ANGLE"/></animation>)"
      R"(</library_animations>{}<library_visual_scenes><visual_scene id="S">{}</visual_scene>)"
      R"(</library_visual_scenes><scene><instance_visual_scene url="#S"/></scene></COLLADA>)",
      asset, source("t", times, "TIME"), source("v", degrees, "ANGLE"), libraries, nodes);
}

}  // namespace motiondb::tests
