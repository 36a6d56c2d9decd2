#include "import/scene/scene_file.h"

#include <assimp/BaseImporter.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/types.h>
#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Logger.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "import/scene/gltf_animation.h"
#include "import/scene/gltf_document.h"
#include "text/utf8.h"

namespace motiondb::importer {
namespace {

std::size_t CountText(std::string_view bytes, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = bytes.find(text); at != bytes.npos; at = bytes.find(text, at + 1)) ++count;
  return count;
}

// Counts the objects of a class: in binary files, names of records follow their length as one byte
// (strings: as four bytes); in text files, ": " follows them.
std::size_t CountFbxObjects(std::string_view bytes, std::string_view name) {
  const bool is_binary = bytes.starts_with("Kaydara FBX Binary");
  return CountText(bytes, is_binary ? fmt::format("{}{}", static_cast<char>(name.size()), name)
                                    : fmt::format("{}: ", name));
}

}  // namespace

std::optional<std::string> NoteOnFbxLayers(std::string_view bytes) {
  const std::size_t layers = CountFbxObjects(bytes, "AnimationLayer");
  const std::size_t takes = CountFbxObjects(bytes, "AnimationStack");
  if (layers <= takes || takes == 0) return std::nullopt;
  return fmt::format(
      "{} animation layers in {} take{}: layers are not blended, so that the motion may be wrong; "
      "bake or merge the layers before you export the file",
      layers, takes, takes == 1 ? "" : "s");
}

namespace {

// What assimp must know of a format.
struct SceneFormat {
  std::string_view reader;     // part of the name of assimp's reader
  std::string_view path;       // whose extension selects the reader
  std::string_view refers_to;  // advice if the scene needs another file
};

SceneFormat SceneFormatOf(core::FileFormat format, std::string_view bytes) {
  constexpr std::string_view kBinaryGltf = "glTF";
  switch (format) {
    case core::FileFormat::kFbx:
      return {"FBX", "scene.fbx", "embed it"};
    case core::FileFormat::kGltf:
      return {"glTF2", bytes.starts_with(kBinaryGltf) ? "scene.glb" : "scene.gltf",
              "use .glb or embed its buffers"};
    default:
      return {"Collada", "scene.dae", "embed it"};
  }
}

// The only file is the scene, in memory. Remembers the first other file that assimp asks for.
class OnlySceneFile : public Assimp::IOSystem {
 public:
  OnlySceneFile(std::string_view path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  bool Exists(const char* path) const override { return path == path_; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* path, const char* /*mode*/) override {
    if (path == path_) {
      return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                        bytes_.size());
    }
    if (missing_.empty()) missing_ = path;
    return nullptr;
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

  const std::string& missing() const { return missing_; }

 private:
  const std::string_view path_;
  const std::string_view bytes_;
  std::string missing_;
};

// Remembers the errors that assimp logs: parts of the file that it skips.
class SkippedParts : public Assimp::Logger {
 public:
  explicit SkippedParts(std::vector<std::string>& first_notes) : notes_(first_notes) {}

  bool attachStream(Assimp::LogStream* /*stream*/, unsigned /*severity*/) override { return false; }
  bool detachStream(Assimp::LogStream* /*stream*/, unsigned /*severity*/) override { return false; }

 protected:
  void OnDebug(const char* /*message*/) override {}
  void OnVerboseDebug(const char* /*message*/) override {}
  void OnInfo(const char* /*message*/) override {}
  void OnWarn(const char* /*message*/) override {}
  void OnError(const char* message) override {
    constexpr std::size_t kMaxNotes = 3;
    constexpr std::size_t kMaxBytes = 200;
    const std::string_view logged = message;
    // Materials are not read; assimp logs their absence.
    if (notes_.size() == kMaxNotes || logged.find("material") != logged.npos) return;
    notes_.push_back("part of the file was skipped: " +
                     text::ValidUtf8(core::ToUtf8(logged), kMaxBytes));
  }

 private:
  std::vector<std::string>& notes_;
};

// Logs to `notes` during its life.
class LogToNotes {
 public:
  explicit LogToNotes(std::vector<std::string>& notes) {
    Assimp::DefaultLogger::set(new SkippedParts(notes));  // which assimp deletes
  }
  ~LogToNotes() { Assimp::DefaultLogger::set(nullptr); }
  LogToNotes(const LogToNotes&) = delete;
  LogToNotes& operator=(const LogToNotes&) = delete;
};

// Keeps one of assimp's readers: the others would be asked about files that this one rejects.
bool KeepOnlyReader(Assimp::Importer& importer, std::string_view name) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    const std::string_view found = importer.GetImporterInfo(i)->mName;
    if (found.find(name) != found.npos) continue;
    const std::unique_ptr<Assimp::BaseImporter> other(importer.GetImporter(i));
    importer.UnregisterLoader(other.get());
  }
  return importer.GetImporterCount() == 1;
}

void SetProperties(Assimp::Importer& importer) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_MATERIALS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_TEXTURES, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_ALL_GEOMETRY_LAYERS, false);
  // Later versions of assimp than 5.2 turn the scene otherwise.
  importer.SetPropertyBool("AI_CONFIG_IMPORT_FBX_IGNORE_UP_DIRECTION", true);
  importer.SetPropertyInteger(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, 1);
  // assimp would make every node the bone of a mesh, or drop bones without a vertex.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_REMOVE_EMPTY_BONES, false);
}

// Returns why the format's reader need not be tried; empty: it must be tried.
std::string_view ReasonAgainst(core::FileFormat format, std::string_view bytes) {
  if (bytes.empty()) return "is empty";
  if (format != core::FileFormat::kCollada) return "";
  if (bytes.starts_with("PK")) return "is a zip archive (.zae): extract its .dae file";
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    return "is UTF-16 text: save it as UTF-8";
  }
  return "";
}

// assimp 5.2 rejects numbers after white space, as in "<color>  0 0 0 1</color>". Moves such white
// space into the start tag, where XML allows it: "<color  >0 0 0 1</color>".
std::string WithNumbersAfterTags(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::string moved(text);
  for (std::size_t tag_end = moved.find('>'); tag_end != moved.npos;
       tag_end = moved.find('>', tag_end + 1)) {
    const std::size_t next = moved.find_first_not_of(kBlanks, tag_end + 1);
    if (next == moved.npos) break;
    const bool is_number =
        std::string_view("+-.0123456789").find(moved[next]) != std::string_view::npos;
    // Not after "/>", "?>", "-->" and "]]>".
    const bool ends_start_tag =
        tag_end > 0 && std::string_view("/?-]").find(moved[tag_end - 1]) == std::string_view::npos;
    if (is_number && ends_start_tag && next > tag_end + 1) {
      moved[tag_end] = ' ';
      moved[next - 1] = '>';
    }
    tag_end = next - 1;
  }
  return moved;
}

void ThrowIfOutOfMemory(const std::exception_ptr& exception) {
  if (exception == nullptr) return;
  try {
    std::rethrow_exception(exception);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (...) {  // assimp has its message
    return;
  }
}

// The frame rate that WriteGlb states.
std::optional<double> StatedGltfRate(const GltfDocument& document) {
  const nlohmann::json& extras = GltfMember(GltfMember(document.json(), "asset"), "extras");
  const nlohmann::json& rate = GltfMember(extras, "frame_rate_hz");
  if (!rate.is_number() || !core::IsFrameRate(rate.get<double>())) return std::nullopt;
  return rate.get<double>();
}

// The line at which the file ends to be XML, which assimp does not report.
absl::Status MalformedXml(core::SourceFile file) {
  tinyxml2::XMLDocument document;
  if (document.Parse(file.bytes.data(), file.bytes.size()) == tinyxml2::XML_SUCCESS) {
    return core::InvalidArgument("{}: is not well-formed XML", file.name);
  }
  return core::InvalidArgument(
      "{}:{}: expected well-formed XML, found {}: is it truncated? It ends at byte {}", file.name,
      document.ErrorLineNum(), document.ErrorName(), file.bytes.size());
}

absl::Status Failure(std::string_view name, std::string_view message) {
  constexpr std::size_t kMaxMessage = 300;  // assimp repeats parts of the file
  return core::InvalidArgument("{}: {}", name, text::ValidUtf8(core::ToUtf8(message), kMaxMessage));
}

}  // namespace

absl::StatusOr<SceneFile> LoadScene(core::FileFormat format, core::SourceFile file) {
  if (const std::string_view reason = ReasonAgainst(format, file.bytes); !reason.empty()) {
    return Failure(file.name, reason);
  }
  const SceneFormat known = SceneFormatOf(format, file.bytes);
  std::string collada;
  if (format == core::FileFormat::kCollada) {
    collada = WithNumbersAfterTags(file.bytes);
    file.bytes = collada;
  }
  SceneFile read{.importer = std::make_unique<Assimp::Importer>()};
  bool has_curves = false;
  if (format == core::FileFormat::kGltf) {
    // Its memory is free while assimp reads.
    MOTIONDB_ASSIGN_OR_RETURN(const GltfDocument document, GltfDocument::Parse(file));
    MOTIONDB_RETURN_IF_ERROR(CheckGltf(document));
    has_curves = NeedsGltfCurves(document);
    read.key_rate_hz = StatedGltfRate(document);
  }
  Assimp::Importer& importer = *read.importer;
  if (!KeepOnlyReader(importer, known.reader)) {
    return absl::InternalError(fmt::format("assimp has no reader of {}", known.reader));
  }
  SetProperties(importer);
  auto* const files = new OnlySceneFile(known.path, file.bytes);
  importer.SetIOHandler(files);  // which takes ownership
  std::string message;
  try {
    const LogToNotes log(read.notes);
    read.scene = importer.ReadFile(std::string(known.path), 0);
    if (read.scene == nullptr) message = importer.GetErrorString();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    message = error.what();
  }
  ThrowIfOutOfMemory(importer.GetException());
  if (read.scene != nullptr && read.scene->mRootNode != nullptr) {
    if (format == core::FileFormat::kFbx) {
      if (auto note = NoteOnFbxLayers(file.bytes)) read.notes.push_back(*std::move(note));
    }
    if (!has_curves) return read;
    MOTIONDB_ASSIGN_OR_RETURN(const GltfDocument document, GltfDocument::Parse(file));
    MOTIONDB_ASSIGN_OR_RETURN(read.curves, ReadGltfCurves(document, *read.scene));
    return read;
  }
  if (!files->missing().empty()) {
    return Failure(file.name, fmt::format("refers to the file '{}': {}",
                                          core::Shown(files->missing()), known.refers_to));
  }
  if (message.find("malformed XML") != message.npos) return MalformedXml(file);
  return Failure(file.name, message.empty() ? "has no scene" : message);
}

}  // namespace motiondb::importer
