#include "client/cli/clip_files.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "tests/client/temporary_folder.h"

namespace motiondb::tests::clip_files_test {
namespace {

namespace fs = std::filesystem;
using client::FilesOfArguments;
using client::ParseClipList;
using Paths = std::vector<fs::path>;

absl::StatusOr<Paths> Files(const std::vector<std::string>& arguments,
                            const std::string& input = "") {
  std::istringstream stream(input);
  return FilesOfArguments(arguments, stream);
}

std::string ErrorOf(const std::vector<std::string>& arguments) {
  return std::string(Files(arguments).status().message());
}

TEST_CASE("ClipFiles: a file need not exist", "[client][cli]") {
  CHECK(Files({"b.bvh", "none/a.txt"}).value() == Paths{"b.bvh", "none/a.txt"});
  CHECK(Files({}).value().empty());
}

TEST_CASE("ClipFiles: a folder is all motion files below it, in order of path", "[client][cli]") {
  const TemporaryFolder folder;
  for (const char* name : {"walk/b.BVH", "walk/a.amc", "walk/a.asf", "run/1/c.trc", "run/d.c3d",
                           "z.bvh", "notes.txt", "bvh", ".hidden.bvh", ".git/e.bvh"}) {
    folder.Write(name, "");
  }
  fs::create_directory_symlink(folder.path(), folder / "cycle");
  const Paths expected = {folder / "run/1/c.trc", folder / "run/d.c3d", folder / "walk/a.amc",
                          folder / "walk/b.BVH", folder / "z.bvh"};
  CHECK(Files({folder.path().string()}).value() == expected);
  // A folder that is named is read, also if it is hidden.
  CHECK(Files({(folder / ".git").string(), "x.bvh"}).value() ==
        Paths{folder / ".git/e.bvh", "x.bvh"});
  CHECK(Files({(folder / "cycle/run").string()}).value().size() == 2);
}

TEST_CASE("ClipFiles: a folder without motion files is an error", "[client][cli]") {
  const TemporaryFolder folder;
  folder.Write("a.asf", "");
  folder.Write(".hidden/a.bvh", "");
  CHECK(ErrorOf({folder.path().string()}) ==
        folder.path().string() +
            ": has no motion files (.bvh, .amc, .trc, .c3d, .csv, .npz, .glb, .gltf, "
            ".vrm, .fbx, .dae)");
}

TEST_CASE("ClipFiles: a pattern is expanded, unless a file has that name", "[client][cli]") {
  const TemporaryFolder folder;
  for (const char* name : {"take1.bvh", "take2.bvh", "take[1].bvh", "set/take3.bvh"}) {
    folder.Write(name, "");
  }
  CHECK(Files({(folder / "take?.bvh").string()}).value() ==
        Paths{folder / "take1.bvh", folder / "take2.bvh"});
  CHECK(Files({(folder / "take[1].bvh").string()}).value() == Paths{folder / "take[1].bvh"});
  CHECK(Files({(folder / "take[2-9].bvh").string()}).value() == Paths{folder / "take2.bvh"});
  // A match may be a folder.
  CHECK(Files({(folder / "s*").string()}).value() == Paths{folder / "set/take3.bvh"});
  const std::string none = (folder / "walk*.bvh").string();
  CHECK(ErrorOf({none}) == none + ": no file matches");
}

TEST_CASE("ClipFiles: - reads one path per line", "[client][cli]") {
  const TemporaryFolder folder;
  const auto a = folder.Write("set/a.bvh", "");
  CHECK(Files({"first.bvh", "-", "last.bvh"}, "one two.bvh\r\n\n \t\n" + a.string() + "\nb*.bvh")
            .value() == Paths{"first.bvh", "one two.bvh", a, "b*.bvh", "last.bvh"});
  CHECK(Files({"-"}, (folder / "set").string() + "\n").value() == Paths{a});
  CHECK(Files({"-"}, "\n\n").value().empty());
}

TEST_CASE("ClipFiles: an input that is too large is an error", "[client][cli]") {
  std::istringstream input(std::string((std::size_t{64} << 20) + 1, 'x'));
  CHECK(FilesOfArguments({"-"}, input).status().message() ==
        "standard input: is larger than 64 MiB");
}

std::string ListErrorOf(const std::string& text) {
  return std::string(ParseClipList("sets/a.tsv", text).status().message());
}

TEST_CASE("ClipList: columns in any order, with unknown columns", "[client][cli]") {
  const auto clips = ParseClipList(
      "sets/a.tsv", "label\tframes\tsubject\tpath\tskeleton\nwalk\t12\tbk\t../w.amc\t../bk.asf\n");
  REQUIRE(clips.ok());
  REQUIRE(clips->size() == 1);
  CHECK((*clips)[0].path == "sets/../w.amc");
  CHECK((*clips)[0].label == "walk");
  CHECK((*clips)[0].subject == "bk");
  CHECK((*clips)[0].skeleton == "sets/../bk.asf");
}

TEST_CASE("ClipList: accepts CRLF, blank lines, comments and a byte-order mark", "[client][cli]") {
  const auto clips = ParseClipList(
      "a.tsv", "\xEF\xBB\xBFpath\tlabel\r\n\r\n# held back\r\n/data/one.bvh\twalk\r\ntwo.bvh\t");
  REQUIRE(clips.ok());
  REQUIRE(clips->size() == 2);
  CHECK((*clips)[0].path == "/data/one.bvh");
  CHECK((*clips)[0].label == "walk");
  CHECK((*clips)[1].path == "two.bvh");
  CHECK((*clips)[1].label.empty());
  CHECK((*clips)[1].skeleton.empty());
}

TEST_CASE("ClipList: errors name file, line and what was expected", "[client][cli]") {
  CHECK_THAT(ListErrorOf(""), Catch::StartsWith("sets/a.tsv:1: expected a header line"));
  CHECK_THAT(
      ListErrorOf("\nfile\tlabel\n"),
      Catch::StartsWith("sets/a.tsv:2: expected a header line") && Catch::Contains("\"path\""));
  CHECK(ListErrorOf("path\tlabel\nw.bvh\twalk\nx.bvh\n") ==
        "sets/a.tsv:3: expected 2 cells, separated by tabs, found 1");
  CHECK(ListErrorOf("path\tlabel\n\twalk\n") == "sets/a.tsv:2: expected a path, found nothing");
}

}  // namespace
}  // namespace motiondb::tests::clip_files_test
