#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>

#include "tests/client/fake_server.h"
#include "tests/client/plot/recognition_answers.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::recognition_plot_command_test {
namespace {

using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;

// Six windows of walk, of which the last four are probably unknown.
v1::RecognizeResponse WalkThenUnknown() {
  v1::RecognizeResponse response = WalkThenJog(16, 6);
  for (int i = 0; i < response.windows_size(); ++i) {
    v1::RecognitionWindow& window = *response.mutable_windows(i);
    window.mutable_labels(0)->set_label("walk");
    window.mutable_labels(0)->set_probability(i < 2 ? 0.9 : 0.4);
    window.set_unknown_probability(i < 2 ? 0.1 : 0.6);
  }
  return response;
}

TEST_CASE("motiondb recognize --plot: shows the response of the text", "[client][cli]") {
  FakeServer server;
  server.Answer("Recognize", WalkThenUnknown());
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const std::string plot = (folder / "a.svg").string();
  const auto result = RunMotiondb(
      server.address(), {"recognize", "walks", file, "--top", "1", "--hop", "0.2", "--plot", plot});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("FROM (s)") && EndsWith("wrote " + plot + "\n"));
  const std::string svg = ReadFile(plot);
  CHECK_THAT(svg, StartsWith("<?xml") && EndsWith("</svg>\n") && Contains(">unknown: 4 windows<"));
  const auto requests = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].method() == v1::METHOD_BEST);
  CHECK(requests[0].top_count() == 1);

  CHECK(RunMotiondb(server.address(), {"recognize", "walks", file, "--unknown-threshold", "0.7",
                                       "--json", "--plot", plot})
            .exit_code == 0);
  CHECK_THAT(ReadFile(plot), Contains(">walk: 6 windows<") && Contains("above 0.7"));
}

TEST_CASE("motiondb recognize --plot-profile: one query for the answer, three for the layers",
          "[client][cli]") {
  FakeServer server;
  server.Answer("Recognize", WalkThenJog(16));
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const std::string plot = (folder / "a.svg").string();
  const auto result = RunMotiondb(server.address(), {"recognize", "walks", file, "--top", "1",
                                                     "--hop", "0.2", "--plot-profile", plot});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("FROM (s)") && EndsWith("wrote " + plot + "\n"));
  CHECK_THAT(ReadFile(plot), StartsWith("<?xml") && EndsWith("</svg>\n"));
  const auto requests = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(requests.size() == 4);
  CHECK(requests[0].method() == v1::METHOD_BEST);
  CHECK(requests[0].top_count() == 1);
  const int layers[] = {0, 0, 8, 4};
  for (int i = 0; i < 4; ++i) {
    CHECK(requests[i].layer() == layers[i]);
    CHECK(requests[i].hop_seconds() == 0.2);
    CHECK(requests[i].observation().file().data() == "HIERARCHY");
    if (i == 0) continue;
    CHECK(requests[i].method() == v1::METHOD_PAPER);
    CHECK(requests[i].top_count() == 0);
  }

  const auto one =
      RunMotiondb(server.address(), {"recognize", "walks", file, "--layer", "6", "--method",
                                     "paper", "--json", "--plot-profile", plot});
  CHECK(one.exit_code == 0);
  CHECK(Count(one.out, "\n") == 1);
  const auto all = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(all.size() == 6);
  CHECK(all[4].method() == v1::METHOD_PAPER);
  CHECK(all[5].layer() == 6);
}

TEST_CASE("motiondb recognize --plot-profile: failures leave no file", "[client][cli]") {
  FakeServer server;
  server.Answer("Recognize", WalkThenJog(16));
  server.Answer("Recognize", WalkThenJog(16));
  server.Fail("Recognize", 9, "the model is gone");
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto wrong =
      RunMotiondb(server.address(), {"recognize", "walks", file, "--plot", "picture.pdf"});
  CHECK(wrong.exit_code == 2);
  CHECK(wrong.out == "");
  CHECK_THAT(wrong.err, Contains("--plot picture.pdf") && Contains("FILE.svg"));
  CHECK(server.Requests<v1::RecognizeRequest>("Recognize").empty());
  const auto gone = RunMotiondb(server.address(), {"recognize", "walks", file, "--plot-profile",
                                                   (folder / "a.svg").string()});
  CHECK(gone.exit_code == 1);
  CHECK_THAT(gone.out, StartsWith("FROM (s)") && !Contains("wrote"));
  CHECK_THAT(gone.err, Contains("the model is gone"));
  const auto files = std::distance(std::filesystem::directory_iterator(folder.path()),
                                   std::filesystem::directory_iterator());
  CHECK(files == 1);
  CHECK(RunMotiondb(server.address(), {"recognize", "walks", file, "--method", "luck"}).exit_code ==
        2);
}

TEST_CASE("motiondb predict --method: becomes the request", "[client][cli]") {
  FakeServer server;
  server.Answer("Predict", v1::PredictResponse());
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  CHECK(RunMotiondb(server.address(), {"predict", "walks", file, "--json"}).exit_code == 0);
  CHECK(RunMotiondb(server.address(), {"predict", "walks", file, "--json", "--method", "paper"})
            .exit_code == 0);
  const auto requests = server.Requests<v1::PredictRequest>("Predict");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].method() == v1::METHOD_BEST);
  CHECK(requests[1].method() == v1::METHOD_PAPER);
}

}  // namespace
}  // namespace motiondb::tests::recognition_plot_command_test
