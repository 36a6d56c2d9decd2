#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::query_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("motiondb recognize: options are sent in the request", "[client][cli]") {
  FakeServer server;
  v1::RecognizeResponse answer;
  auto* window = answer.add_windows();
  window->set_end_seconds(0.4);
  window->add_labels()->set_label("walk");
  server.Answer("Recognize", answer);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto text = RunMotiondb(server.address(), {"recognize", "walks", file});
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, StartsWith("FROM (s)") && Contains("  walk  "));
  const auto json =
      RunMotiondb(server.address(),
                  {"recognize", "walks", file, "--window", "all", "--hop", "0.2", "--layer", "7",
                   "--top", "3", "--floor", "0", "--paths", "5", "--method", "paper", "--json"});
  CHECK_THAT(json.out, StartsWith("{\"windows\":[{\"start_seconds\":0,\"end_seconds\":0.4"));
  const auto requests = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].database() == "databases/walks");
  CHECK(requests[0].observation().file().data() == "HIERARCHY");
  CHECK(requests[0].window_seconds() == 0.4);
  CHECK(!requests[0].whole());
  CHECK(!requests[0].has_transition_floor());
  CHECK(requests[1].whole());
  CHECK(requests[1].hop_seconds() == 0.2);
  CHECK(requests[1].layer() == 7);
  CHECK(requests[1].top_count() == 3);
  CHECK(requests[1].has_transition_floor());
  CHECK(requests[1].transition_floor() == 0);
  CHECK(requests[1].generation() == v1::GENERATION_TOP_PATHS);
  CHECK(requests[1].path_count() == 5);
}

TEST_CASE("motiondb estimate: options are sent in the request", "[client][cli]") {
  FakeServer server;
  v1::EstimateResponse answer;
  answer.add_paths()->add_node_ids(4);
  server.Answer("Estimate", answer);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto result = RunMotiondb(server.address(), {"estimate", "walks", file, "--paths", "3",
                                                     "--max-candidates", "0", "--json"});
  CHECK_THAT(result.out, Contains("\"node_ids\":[4]"));
  const auto requests = server.Requests<v1::EstimateRequest>("Estimate");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].path_count() == 3);
  CHECK(requests[0].has_max_candidates());
  CHECK(requests[0].max_candidates() == 0);
}

TEST_CASE("motiondb predict: one time, or one line for each", "[client][cli]") {
  FakeServer server;
  v1::PredictResponse one;
  one.set_at_seconds(1.5);
  server.Answer("Predict", one);
  v1::PredictSeriesResponse first, second;
  first.mutable_prediction()->set_at_seconds(0.4);
  second.mutable_prediction()->set_at_seconds(0.9);
  server.Answer("PredictSeries", first, second);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto at = RunMotiondb(server.address(), {"predict", "walks", "--at", "1.5", "--horizon",
                                                 "0.1,0.25", file, "--json"});
  CHECK_THAT(at.out, StartsWith("{\"at_seconds\":1.5,"));
  const auto requests = server.Requests<v1::PredictRequest>("Predict");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].at_seconds() == 1.5);
  CHECK(requests[0].history_seconds() == 0.4);
  REQUIRE(requests[0].horizon_seconds_size() == 2);
  CHECK(requests[0].horizon_seconds(1) == 0.25);

  const auto every =
      RunMotiondb(server.address(), {"predict", "walks", file, "--every", "0.5", "--json"});
  CHECK(every.exit_code == 0);
  CHECK(std::count(every.out.begin(), every.out.end(), '\n') == 2);
  CHECK_THAT(every.out, StartsWith("{\"at_seconds\":0.4,") && Contains("\n{\"at_seconds\":0.9,"));
  const auto series = server.Requests<v1::PredictSeriesRequest>("PredictSeries");
  REQUIRE(series.size() == 1);
  CHECK(series[0].every_seconds() == 0.5);
  CHECK(!series[0].prediction().has_at_seconds());
  CHECK(series[0].prediction().horizon_seconds_size() == 6);
}

TEST_CASE("motiondb find: a part of files or of a clip", "[client][cli]") {
  FakeServer server;
  v1::FindResponse answer;
  v1::FindMatch& match = *answer.add_matches();
  match.set_clip("databases/walks/clips/07_01");
  match.set_start_seconds(1.5);
  match.set_end_seconds(3);
  match.set_score(0.75);
  server.Answer("Find", answer);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto text = RunMotiondb(server.address(), {"find", "walks", file, "--from", "0.5", "--to",
                                                   "2", "--top", "3", "--filter", "label = \"a\""});
  CHECK(text.out == "CLIP   FROM (s)  TO (s)  SCORE\n07_01      1.50    3.00  0.750\n");
  const auto json = RunMotiondb(
      server.address(), {"find", "walks", "--clip", "07_01@1.5-3", "--exhaustive", "--json"});
  CHECK_THAT(json.out,
             StartsWith("{\"matches\":[{\"clip\":\"databases/walks/clips/07_01\",\"start_seconds\":"
                        "1.5,\"end_seconds\":3,\"score\":0.75}]"));
  folder.Write("b.bvh", "HIERARCHY");
  const auto csv =
      RunMotiondb(server.address(), {"find", "walks", folder.path().string(), "--csv"});
  CHECK_THAT(csv.out, StartsWith("FILE,CLIP,FROM (s),TO (s),SCORE\n") &&
                          Contains("b.bvh,07_01,1.5,3,0.75\n"));
  const auto requests = server.Requests<v1::FindRequest>("Find");
  REQUIRE(requests.size() == 4);
  CHECK(requests[0].database() == "databases/walks");
  CHECK(requests[0].observation().file().data() == "HIERARCHY");
  CHECK(requests[0].start_seconds() == 0.5);
  CHECK(requests[0].end_seconds() == 2);
  CHECK(requests[0].top_count() == 3);
  CHECK(requests[0].filter() == "label = \"a\"");
  CHECK(!requests[0].exhaustive());
  CHECK(requests[1].clip_range().clip() == "databases/walks/clips/07_01");
  CHECK(requests[1].clip_range().start_seconds() == 1.5);
  CHECK(requests[1].clip_range().end_seconds() == 3);
  CHECK(requests[1].exhaustive());
  CHECK(requests[1].top_count() == 10);
  CHECK(!requests[2].has_start_seconds());

  for (const std::vector<std::string>& wrong : {std::vector<std::string>{},
                                                {file, "--clip", "a@1-2"},
                                                {"--clip", "a"},
                                                {"--clip", "a@1"},
                                                {"--clip", "a@2-1"},
                                                {"--clip", "@1-2"},
                                                {"--clip", "a@1-2", "--from", "1"},
                                                {file, "--top", "1001"},
                                                {file, "--from", "-1"}}) {
    std::vector<std::string> words = {"find", "walks"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    CHECK(RunMotiondb(server.address(), words).exit_code == 2);
  }
}

}  // namespace
}  // namespace motiondb::tests::query_command_test
