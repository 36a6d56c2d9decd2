// Measures how fast motion files are read, compared with assimp on the same BVH files and with a
// memory copy of the same bytes. One thread; the files are in memory. Our result is in metres and
// radians, with units and up axis derived. Reports thread processor time: the best of some rounds
// in which the readers alternate.
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/format/motion_file.h"
#include "tests/bench/bench_program.h"
#include "tests/support/real_data.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {
namespace fs = std::filesystem;

struct File {
  std::string name;
  std::string bytes;
  std::string skeleton;  // of an AMC
};

std::vector<fs::path> FilesUnder(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == extension) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

// The folder of a subject has a skeleton with the name of the folder.
fs::path SkeletonBeside(const fs::path& amc) {
  const fs::path folder = amc.parent_path();
  return folder / (folder.filename().string() + ".asf");
}

bool ReadOurs(core::FileFormat format, const File& file) {
  std::optional<core::SourceFile> skeleton;
  if (format == core::FileFormat::kAmc) skeleton = core::SourceFile{"skeleton.asf", file.skeleton};
  return core::ReadMotionFile(format, {file.name, file.bytes}, skeleton).ok();
}

bool ReadAssimp(const File& file) {
  Assimp::Importer importer;
  return importer.ReadFileFromMemory(file.bytes.data(), file.bytes.size(), 0, "bvh") != nullptr;
}

// Loads the files that all readers accept. Exits if there are none.
std::vector<File> Load(const fs::path& folder, const std::string& extension) {
  const bool amc = extension == ".amc";
  std::vector<File> files;
  for (const fs::path& path : FilesUnder(folder, extension)) {
    File file{path.filename().string(), ReadFile(path), ""};
    if (amc) file.skeleton = ReadFile(SkeletonBeside(path));
    const core::FileFormat format = amc ? core::FileFormat::kAmc : core::FileFormat::kBvh;
    if (!ReadOurs(format, file) || (!amc && !ReadAssimp(file))) continue;
    files.push_back(std::move(file));
  }
  if (files.empty()) {
    fmt::print(stderr, "{}: expected readable files *{}\n", folder.string(), extension);
    std::exit(1);
  }
  return files;
}

double Megabytes(const std::vector<File>& files) {
  double bytes = 0;
  for (const File& file : files) bytes += static_cast<double>(file.bytes.size());
  return bytes / 1e6;
}

// Returns megabytes per second of each reader over the files, the best of `rounds`.
std::vector<double> Rates(const std::vector<File>& files, int rounds,
                          const std::vector<std::function<void(const File&)>>& readers) {
  std::vector<double> best(readers.size(), INFINITY);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t r = 0; r < readers.size(); ++r) {
      const double begin = ThreadCpuSeconds();
      for (const File& file : files) readers[r](file);
      best[r] = std::min(best[r], ThreadCpuSeconds() - begin);
    }
  }
  for (double& seconds : best) seconds = Megabytes(files) / seconds;
  return best;
}

BenchTable Run(int rounds) {
  const std::vector<File> bvh = Load(DataDir() / "cmu", ".bvh");
  const std::vector<File> amc = Load(DataDir() / "cmu", ".amc");
  std::string copy;
  const auto copy_file = [&](const File& file) {
    copy.resize(file.bytes.size());
    std::memcpy(copy.data(), file.bytes.data(), file.bytes.size());
  };
  const std::vector<double> of_bvh =
      Rates(bvh, rounds,
            {[](const File& file) { ReadOurs(core::FileFormat::kBvh, file); },
             [](const File& file) { ReadAssimp(file); }, copy_file});
  const std::vector<double> of_amc = Rates(
      amc, rounds, {[](const File& file) { ReadOurs(core::FileFormat::kAmc, file); }, copy_file});

  BenchTable table{"parsing", {}, {}};
  table.rows.push_back(
      RatioRow("BVH parsing", of_bvh[0], "assimp, same files", of_bvh[1], "MB/s", AtLeast(5)));
  table.rows.push_back(
      RatioRow("BVH parsing", of_bvh[0], "memory copy of the file", of_bvh[2], "MB/s", NoBar()));
  table.rows.push_back(
      RatioRow("AMC parsing", of_amc[0], "assimp on the BVH files", of_bvh[1], "MB/s", AtLeast(5)));
  table.rows.push_back(
      RatioRow("AMC parsing", of_amc[0], "memory copy of the file", of_amc[1], "MB/s", NoBar()));
  table.notes.push_back(fmt::format(
      "parsing: {} recorded BVH files ({:.1f} MB) and {} AMC files with their ASF ({:.1f} MB) from "
      "memory, one thread, the best of {} rounds; assimp without post-processing",
      bvh.size(), Megabytes(bvh), amc.size(), Megabytes(amc), rounds));
  return table;
}

int Main(int argc, char** argv) {
  BenchProgram program("Measures how fast motion files are read.", "motiondb_bench_parse");
  int rounds = 20;
  program.app()
      .add_option("--rounds", rounds, "Times that every file is read")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  return program.Run(argc, argv, [&] { return Run(rounds); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
