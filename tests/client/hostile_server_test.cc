// Control characters in strings of a server must not reach a terminal or a picture.
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <motiondb/v1/query.pb.h>
#include <motiondb/v1/server.pb.h>
#include <motiondb/v1/store.pb.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/plot/picture.h"
#include "client/cli/terminal/terminal.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"
#include "tests/support/shown_text_cases.h"
#include "text/display_text.h"

namespace motiondb::tests::hostile_server_test {
namespace {

using Catch::Contains;

// A line feed, escape sequences of 7 and 8 bits, a bidirectional override and a line separator.
const std::string kHostile =
    "A\n\x1b[31m\xC2\x9B"
    "2J\xE2\x80\xAE\xE2\x80\xA8\xE2\x81\xA6Z";

// Checks that there are no control characters except the line feeds of the program.
void CheckHarmless(const std::string& output) {
  CAPTURE(output);
  CHECK(output == text::DisplayLines(output));
  CHECK_THAT(output, !Contains("A\n"));
}

TEST_CASE("DisplayText: used by pictures and progress lines", "[client][cli]") {
  CheckHarmless(client::SvgText(kHostile));
  client::Canvas canvas;
  canvas.SetTitle(kHostile);
  canvas.Label("title", 0, 0, kHostile);
  canvas.Circle("title", 0, 0, 1).tooltip = kHostile;
  CheckHarmless(client::SvgOf(canvas));
  CheckHarmless(client::ProgressLine(0.5, kHostile, 80));
  // Text is cut between characters.
  for (int columns = 35; columns < 50; ++columns) {
    CHECK(text::IsUtf8(
        client::ProgressLine(0.5, "\xC3\xA4\xE2\x82\xAC\xC3\xA4\xE2\x82\xAC", columns)));
  }
}

// Runs every command that prints strings of the server.
TEST_CASE("motiondb: strings of the server cannot control the terminal", "[client][cli]") {
  FakeServer server;
  v1::Clip clip;
  clip.set_name("databases/d/clips/" + kHostile);
  for (std::string* const text :
       {clip.mutable_label(), clip.mutable_subject(), clip.mutable_file_name()}) {
    *text = kHostile;
  }
  v1::ListClipsResponse clips;
  *clips.add_clips() = clip;
  server.Answer("ListClips", clips);
  v1::Database database;
  database.set_name("databases/" + kHostile);
  database.set_marker_set(kHostile);
  v1::ListDatabasesResponse databases;
  *databases.add_databases() = database;
  server.Answer("ListDatabases", databases);
  v1::CreateDatabaseResponse created;
  *created.mutable_database() = database;
  server.Answer("CreateDatabase", created);
  v1::DatabaseStatistics description;
  description.set_name(database.name());
  description.add_labels()->set_label(kHostile);
  server.Answer("GetDatabase", WithStatistics(description));
  v1::ListOperationsResponse operations;
  v1::Operation& operation = *operations.add_operations();
  operation.set_name("operations/" + kHostile);
  operation.set_stage(kHostile);
  operation.mutable_error()->set_message(kHostile);
  server.Answer("ListOperations", operations);
  v1::ListAuditEntriesResponse audit;
  v1::AuditEntry& entry = *audit.add_entries();
  for (std::string* const text :
       {entry.mutable_principal(), entry.mutable_peer(), entry.mutable_method(),
        entry.mutable_resource(), entry.mutable_request_id()}) {
    *text = kHostile;
  }
  server.Answer("ListAuditEntries", audit);
  v1::ListTokensResponse tokens;
  tokens.add_tokens()->set_description(kHostile);
  server.Answer("ListTokens", tokens);
  v1::CreateTokenResponse token;
  token.mutable_token()->set_name(kHostile);
  token.set_secret(kHostile);
  server.Answer("CreateToken", token);
  v1::GetServerStatusResponse status;
  status.set_version(kHostile);
  v1::Corruption& corruption = *status.add_corruptions();
  corruption.set_resource(kHostile);
  corruption.set_description(kHostile);
  server.Answer("GetServerStatus", status);
  v1::VerifyStoreResponse verified;
  *verified.mutable_corruption() = corruption;
  server.Answer("VerifyStore", verified);
  server.Fail("GetModel", 13, kHostile);
  server.Fail("CancelOperation", 3, kHostile);
  v1::IngestClipResponse ingested;
  *ingested.mutable_clip() = clip;
  server.Answer("GetDatabase", v1::GetDatabaseResponse());
  server.Answer("IngestClip", ingested);

  v1::RecognizeResponse recognized;
  v1::RecognitionWindow& window = *recognized.add_windows();
  window.set_end_seconds(0.4);
  window.set_layer(8);
  window.add_labels()->set_label(kHostile);
  v1::ClipProbability& best = *window.add_clips();
  best.set_clip(clip.name());
  best.set_label(kHostile);
  server.Answer("Recognize", recognized);

  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "a").string();
  const std::string plot = (folder / "plot.svg").string();
  const std::string profile = (folder / "profile.svg").string();
  for (const std::vector<std::string>& command : std::initializer_list<std::vector<std::string>>{
           {"list"},
           {"list", "--csv"},
           {"list", "d", "--csv"},
           {"recognize", "d", file, "--plot", plot},
           {"recognize", "d", file, "--plot-profile", profile},
           {"recognize", "d", file, "--csv"},
           {"list", "d"},
           {"create", "d"},
           {"describe", "d"},
           {"operations", "list"},
           {"operations", "cancel", "x"},
           {"audit"},
           {"token", "list"},
           {"token", "create", "--role", "reader"},
           {"status"},
           {"verify"},
           {"ingest", "d", file},
           {"delete", "d", kHostile},
           {"list", "d", kHostile},
           {"recognize", "d", kHostile + ".bvh"}}) {
    CAPTURE(command);
    const auto result = RunMotiondb(server.address(), command);
    CheckHarmless(result.out);
    CheckHarmless(result.err);
    CHECK(result.out.size() + result.err.size() > 0);
  }

  for (const std::string& picture : {plot, profile}) {
    CAPTURE(picture);
    CheckHarmless(ReadFile(picture));
    CHECK_THAT(ReadFile(picture), Contains("2J"));  // the visible part
  }
  std::string offered = RunMotiondb(server.address(), {"__complete", "describe", ""}).out;
  CHECK_THAT(offered, Contains("2J"));
  std::erase(offered, '\t');  // before the description
  CheckHarmless(offered);

  // JSON keeps the complete strings.
  const auto json = RunMotiondb(server.address(), {"--json", "list", "d"});
  CheckHarmless(json.out);
  CHECK(nlohmann::json::parse(json.out)["label"] == kHostile);
  CHECK(nlohmann::json::parse(RunMotiondb(server.address(), {"--json", "status"}).out)["version"] ==
        kHostile);
}

TEST_CASE("motiondb: a token in the place of a name is not printed", "[client][cli]") {
  FakeServer server;
  server.Fail("GetDatabase", 5, "there is no database '" + AnyToken() + "'");
  const TemporaryFolder folder;
  for (const std::vector<std::string>& command : std::initializer_list<std::vector<std::string>>{
           {"describe", AnyToken()},
           {"status", AnyToken()},
           {AnyToken()},
           {"status", "--watch", AnyToken()},
           {"status", "--token-file", AnyToken()},
           {"plan", "d", "--goal", AnyToken()},
           {"plan", "d", "--goal", "1,2,3", "--start", AnyToken()},
           {"plan", "d", "--goal", "1,2,3", "--out", AnyToken()},
           {"recognize", "d", AnyToken()},
           {"ingest", "d", AnyToken()},
           {"create", "d", "--marker-set", AnyToken()},
           {"token", "create", "--role", AnyToken()},
           {"export", "d", AnyToken(), "--out", folder.path().string()}}) {
    CAPTURE(command);
    const auto result = RunMotiondb(server.address(), command);
    CHECK(result.exit_code != 0);
    CHECK_THAT(result.err, !Contains("ccc") && Contains("motiondb: "));
    CHECK_THAT(result.out, !Contains("ccc"));
  }
}

}  // namespace
}  // namespace motiondb::tests::hostile_server_test
