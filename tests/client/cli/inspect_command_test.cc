#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/humanoid_bvh.h"

namespace motiondb::tests::inspect_command_test {
namespace {

using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;

constexpr char kNoServer[] = "127.0.0.1:1";
constexpr char kPole[] =
    "HIERARCHY\nROOT base\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\n"
    "OFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.1\n0 0 0\n0 0 1\n";

ProgramResult RunInspect(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "inspect");
  return RunMotiondb(kNoServer, arguments);
}

TEST_CASE("motiondb inspect: one file with its body parts, without a server", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", HumanoidBvh(100, 60)).string();
  const std::string plot = (folder / "a.svg").string();
  const std::string mapping = (folder / "mapping.txt").string();
  const auto result = RunInspect({file, "--plot", plot, "--write-mapping", mapping});
  CHECK(result.err.empty());
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out,
             StartsWith(file + "\n") && Contains("left knee") &&
                 Contains("unit        0.01 m (deduced)") && Contains("leg length  0.82 m") &&
                 Contains("plausible   yes: a database of standard34 would accept the file"));
  CHECK_THAT(folder.Read("mapping.txt"),
             StartsWith("motiondb-marker-set 1\nextend standard34\nmapping "));
  CHECK_THAT(folder.Read("a.svg"), Contains("LeftLeg: left knee") && Contains("from the left"));
}

TEST_CASE("motiondb inspect: a line for each of several files, and rejected ones by reason",
          "[client][cli]") {
  const TemporaryFolder folder;
  folder.Write("files/a.bvh", HumanoidBvh(100, 60));
  folder.Write("files/b.bvh", kPole);
  folder.Write("files/c.bvh", "HIERARCHY\n");
  const auto result = RunInspect({(folder / "files").string()});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.out, StartsWith("ok        ") && Contains("a.bvh: 2 s, 30 Hz, leg 0.82 m") &&
                             Contains("1 of 3 files would be accepted"));
  CHECK_THAT(result.err, Contains("motiondb mapping add DB MAPPING") && Contains("c.bvh") &&
                             Contains("ingest would reject 2 of 3 files"));
}

TEST_CASE("motiondb inspect: a wrong flag is answered with the right one", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", HumanoidBvh(100, 60)).string();
  const auto result = RunInspect({file, "--metres-per-unit", "1"});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.out, Contains("try         --metres-per-unit 0.01\n"));
}

TEST_CASE("motiondb inspect: --json prints one object per file, in order", "[client][cli]") {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {"--json"};
  for (const char* name : {"b.bvh", "a.bvh", "none.bvh"})
    arguments.push_back((folder / name).string());
  folder.Write("a.bvh", HumanoidBvh(100, 2000));
  folder.Write("b.bvh", HumanoidBvh(1, 20));
  const auto result = RunInspect(arguments);
  CHECK(result.exit_code == 1);
  std::istringstream lines(result.out);
  std::vector<nlohmann::json> objects;
  for (std::string line; std::getline(lines, line);) objects.push_back(nlohmann::json::parse(line));
  REQUIRE(objects.size() == 3);
  CHECK(objects[0].at("metres_per_unit") == 1);
  CHECK(objects[1].at("metres_per_unit") == 0.01);
  CHECK(objects[1].at("frame_count") == 2000);
  CHECK(objects[1].at("points").size() >= 21);
  CHECK_THAT(objects[2].at("error").get<std::string>(), EndsWith(": no such file"));
}

TEST_CASE("motiondb inspect: bad answers of the import program are errors", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "").string();
  const std::string b = folder.Write("b.bvh", "").string();
  const std::string good = R"({"problems":[],"points":[]})";
  const std::string deep(1000, '[');
  for (const std::string& answers : std::vector<std::string>{
           "", "{\"index\":0,\"result\":" + good + "}\n", "{\"index\":\"x\"}\n", "{}\n", "x\n",
           "{\"index\":9,\"result\":" + good + "}\n",
           "{\"index\":0,\"result\":{\"error\":\"e\"}}\n{\"index\":0,\"result\":{}}\n",
           "{\"index\":0,\"result\":" + deep + "}\n", "{\"index\":0,\"result\":{}}\n"}) {
    CAPTURE(answers);
    folder.Write("answers", answers);
    const auto program =
        folder.Write("import", "#!/bin/sh\ncat > /dev/null\ncat " + (folder / "answers").string());
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("MOTIONDB_IMPORT", program.c_str(), 1);
    const auto result = RunInspect({a, b});
    unsetenv("MOTIONDB_IMPORT");
    CHECK(result.exit_code == 1);
    CHECK_THAT(result.err, Contains("motiondb-import"));
  }
}

TEST_CASE("motiondb inspect: the takes of a file", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", HumanoidBvh(100, 60)).string();
  auto answer = nlohmann::json::parse(RunInspect({file, "--json"}).out);
  CHECK(answer.at("takes").empty());
  answer["take"] = "run";
  answer["take_count"] = 3;
  answer["takes"] = {{{"name", "walk"}, {"duration_seconds", 1.5}},
                     {{"name", "run"}, {"duration_seconds", 2}}};
  folder.Write("answers", nlohmann::json({{"index", 0}, {"result", answer}}).dump() + "\n");
  const auto program =
      folder.Write("import", "#!/bin/sh\ncat > /dev/null\ncat " + (folder / "answers").string());
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  setenv("MOTIONDB_IMPORT", program.c_str(), 1);
  const auto result = RunInspect({file});
  unsetenv("MOTIONDB_IMPORT");
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out,
             Contains("takes       walk  1.5 s\n"
                      "            run  2 s  (inspected here; --take chooses another)\n"));
}

TEST_CASE("motiondb inspect: a text in a file is not taken for an option", "[client][cli]") {
  const TemporaryFolder folder;
  std::string pole = kPole;
  pole.replace(pole.find("base"), 4, "x(--metres-per-unit)");
  const auto result = RunInspect({folder.Write("a.bvh", pole).string()});
  CHECK(result.exit_code == 1);
  CHECK(result.out.find("try  ") == std::string::npos);
}

TEST_CASE("motiondb inspect: wrong use, and a missing motiondb-import", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", HumanoidBvh(100, 20)).string();
  CHECK(RunInspect({file, file, "--plot", "x.svg"}).exit_code == 2);
  CHECK(RunInspect({}).exit_code == 2);
  setenv("MOTIONDB_IMPORT", (folder / "none").c_str(), 1);
  const auto result = RunInspect({file});
  unsetenv("MOTIONDB_IMPORT");
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, StartsWith("motiondb: motiondb-import: ") && Contains("No such file"));
}

}  // namespace
}  // namespace motiondb::tests::inspect_command_test
