#include "import/inspector.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tests/import/scene/scene_files.h"
#include "tests/support/humanoid_bvh.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::inspector_test {
namespace {

using Json = nlohmann::json;

// Returns the answers to the requests, in the order of their indices.
std::vector<Json> Answers(const std::string& requests, const importer::InspectorOptions& options) {
  std::FILE* const output = std::tmpfile();
  REQUIRE(output != nullptr);
  std::istringstream input(requests);
  const absl::Status status = importer::Inspector(options, output).Run(input);
  INFO(status);
  REQUIRE(status.ok());
  std::rewind(output);
  std::string text;
  for (int byte; (byte = std::fgetc(output)) != EOF;) text += static_cast<char>(byte);
  std::fclose(output);
  std::vector<Json> answers;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const Json answer = Json::parse(line);
    answers.resize(std::max(answers.size(), answer.at("index").get<std::size_t>() + 1));
    answers[answer.at("index")] = answer;
  }
  return answers;
}

TEST_CASE("Inspector: answers each request once, also bad ones", "[import]") {
  const TemporaryDirectory folder;
  std::string requests = "no JSON\n{}\n{\"file\":1}\n{\"file\":\"a.txt\"}\n";
  requests += "{\"file\":\"none.bvh\",\"up_axis\":\"w\"}\n";
  for (int i = 0; i < 20; ++i) {
    const std::string path = folder / (std::to_string(i) + ".bvh");
    std::ofstream(path) << HumanoidBvh(100, 20 + i);
    requests += Json({{"file", path}}).dump() + "\n";
  }
  for (const int jobs : {1, 7}) {
    const auto answers = Answers(requests, {.jobs = jobs});
    REQUIRE(answers.size() == 25);
    for (int i = 0; i < 5; ++i) CHECK(answers[i].at("result").contains("error"));
    for (int i = 0; i < 20; ++i) CHECK(answers[5 + i].at("result").at("frame_count") == 20 + i);
  }
}

TEST_CASE("Inspector: the skeleton of an AMC file, and given conventions", "[import]") {
  const TemporaryDirectory folder;
  const std::string path = folder / "a.bvh";
  std::ofstream(path) << HumanoidBvh(100, 20);
  const auto answers =
      Answers(Json({{"file", path}, {"metres_per_unit", 0.02}, {"up_axis", "y"}}).dump() + "\n" +
                  Json({{"file", path}, {"skeleton", folder / "none.asf"}}).dump() + "\n",
              {});
  CHECK(answers[0].at("result").at("metres_per_unit") == 0.02);
  CHECK(answers[0].at("result").at("metres_per_unit_is") == "given");
  CHECK(std::string(answers[1].at("result").at("error")).ends_with("none.asf: no such file"));
}

TEST_CASE("Inspector: a file that ends its reader is rejected, with advice", "[import]") {
  const TemporaryDirectory folder;
  GltfFile deep = NoddingFigure(3);
  for (int n = 1; n < 60'000; ++n) {
    deep.json["nodes"][static_cast<std::size_t>(n)] = {{"children", {n + 1}}};
  }
  deep.json["nodes"].push_back({{"name", "Last"}});
  const std::string path = folder / "deep.gltf";
  std::ofstream(path) << deep.Text();
  const auto answers = Answers(Json({{"file", path}}).dump() + "\n", {});
  CHECK_THAT(answers[0].at("result").at("error").get<std::string>(),
             Catch::StartsWith(path + ": ") &&
                 Catch::Contains("This gltf file is rejected, and nothing is stored. "));
}

TEST_CASE("Inspector: lists all takes of a file, and inspects the chosen one", "[import]") {
  const TemporaryDirectory folder;
  GltfFile file = NoddingFigure(4);
  file.AddChannel(file.AddTake("Rise"), 0, "translation", {0, 1, 2}, {0, 1, 0, 0, 2, 0, 0, 3, 0});
  const std::string path = folder / "two.gltf";
  std::ofstream(path) << file.Text();
  const auto answers = Answers(
      Json({{"file", path}}).dump() + "\n" + Json({{"file", path}, {"take", "Rise"}}).dump() + "\n",
      {});
  const std::vector<std::pair<std::string, int>> expected = {{"Nod", 4}, {"Rise", 61}};
  for (std::size_t i = 0; i < 2; ++i) {
    const Json& result = answers[i].at("result");
    INFO(result.dump());
    CHECK(result.at("take") == expected[i].first);
    CHECK(result.at("frame_count") == expected[i].second);
    CHECK(result.at("take_count") == 2);
    REQUIRE(result.at("takes").size() == 2);
    CHECK(result.at("takes")[0].at("name") == "Nod");
    CHECK(result.at("takes")[0].at("duration_seconds").get<double>() == Approx(0.1));
    CHECK(result.at("takes")[1].at("duration_seconds").get<double>() == Approx(2));
  }
}

TEST_CASE("AnswerLine: a result cannot forge an answer", "[import]") {
  for (const std::string forged :
       {"{}\n{\"index\":0}", "{},\"index\":1,\"x\":{}", "[]", "", "{", "{}{}", "null"}) {
    CAPTURE(forged);
    const Json answer = Json::parse(importer::AnswerLine(7, "a \"b\"", forged));
    CHECK(answer.at("index") == 7);
    CHECK(answer.at("file") == "a \"b\"");
    CHECK(answer.at("result").at("error") == "the reader gave no valid result");
  }
  CHECK(Json::parse(importer::AnswerLine(7, "a", "{\"x\":1}")).at("result").at("x") == 1);
}

}  // namespace
}  // namespace motiondb::tests::inspector_test
