// Tests the methods of the services over HTTP: numbers and errors are the same as over gRPC.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/web/api/api_fixture.h"

namespace sweepstake::server {
namespace {

using rpc::TelemetryClient;
using test_support::Dechunked;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string ErrorOf(const std::string& code, const std::string& reason) {
  return "{\"error\":{\"code\":\"" + code + "\",\"reason\":\"" + reason + "\",\"message\":\"";
}

TEST_F(ApiTest, NumbersAreThoseOfGrpc) {
  TelemetryClient client(channel_);
  client.Open(rpc::HelloMessage());
  Learn(client, 1);
  Learn(client, 2);
  {
    grpc::ClientContext context;
    v1::ListPosteriorsResponse expected;
    const auto stub = v1::PosteriorsService::NewStub(channel_);
    ASSERT_TRUE(stub->ListPosteriors(&context, {}, &expected).ok());
    ASSERT_EQ(expected.scenes(0).arms(0).window_count(), 2u);
    // The time is computed from two clocks, and may differ by a millisecond between two calls.
    const auto without_time = [](v1::ListPosteriorsResponse response) {
      response.mutable_scenes(0)->mutable_activity()->clear_unix_active_since_ms();
      return JsonOf(response);
    };
    for (const char* const request : {"{}", ""}) {
      const Answer answer = Call("PosteriorsService/ListPosteriors", request);
      EXPECT_EQ(answer.status, 200);
      EXPECT_THAT(answer.head, HasSubstr("Content-Type: application/json\r\n"));
      v1::ListPosteriorsResponse answered;
      ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(answer.body, &answered).ok());
      EXPECT_EQ(without_time(answered), without_time(expected));
    }
  }
  {
    grpc::ClientContext context;
    v1::ListSessionsResponse expected;
    const auto stub = v1::SessionsService::NewStub(channel_);
    ASSERT_TRUE(stub->ListSessions(&context, {}, &expected).ok());
    v1::ListSessionsResponse answered;
    ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(
                    Call("SessionsService/ListSessions", "{}").body, &answered)
                    .ok());
    for (v1::ListSessionsResponse* sessions : {&expected, &answered}) {
      ASSERT_EQ(sessions->sessions_size(), 1);
      // Times are computed from two clocks, and may differ by a millisecond between two calls.
      sessions->mutable_sessions(0)->clear_unix_start_ms();
      sessions->mutable_sessions(0)->clear_unix_last_message_ms();
    }
    EXPECT_EQ(JsonOf(answered), JsonOf(expected));
  }
  EXPECT_THAT(Call("PosteriorsService/GetPosterior",
                   R"({"project":"game","scene":"harbour","rewardVersion":1})")
                  .body,
              HasSubstr(R"("windowCount":"2")"));
}

TEST_F(ApiTest, AStreamIsALineForEachMessage) {
  std::string expected;
  EXPECT_EQ(Dechunked(Call("PriorsService/ExportPriors", "{}").body), "");
  for (int i = 0; i < 5; ++i) PutScene("scene " + std::to_string(i), 90);
  grpc::ClientContext context;
  const auto stub = v1::PriorsService::NewStub(channel_);
  const auto reader = stub->ExportPriors(&context, {});
  v1::ExportPriorsResponse part;
  while (reader->Read(&part)) expected += JsonOf(part) + "\n";
  ASSERT_TRUE(reader->Finish().ok());
  const Answer answer = Call("PriorsService/ExportPriors", "{}");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head, HasSubstr("Content-Type: application/x-ndjson\r\n"));
  EXPECT_EQ(Dechunked(answer.body), expected);
  EXPECT_EQ(std::count(expected.begin(), expected.end(), '\n'), 3) << "of 450 records";
}

TEST_F(ApiTest, AnErrorHasTheStatusCodeAndReason) {
  const Answer unknown =
      Call("PosteriorsService/GetPosterior", R"({"project":"game","scene":"nowhere"})");
  EXPECT_EQ(unknown.status, 404);
  EXPECT_THAT(unknown.head, HasSubstr("Content-Type: application/json\r\n"));
  EXPECT_THAT(unknown.body, StartsWith(ErrorOf("NOT_FOUND", "UNKNOWN_SCENE")));
  const Answer invalid = Call("PosteriorsService/ListPosteriors", R"({"pageToken":"x"})");
  EXPECT_EQ(invalid.status, 400);
  EXPECT_THAT(invalid.body, StartsWith(ErrorOf("INVALID_ARGUMENT", "INVALID_MESSAGE")));
}

TEST_F(ApiTest, AStreamThatIsRefusedHasTheStatus) {
  options_.max_transfers = 0;
  server_->Adjust(options_);
  const Answer answer = Call("PriorsService/ExportPriors", "{}");
  EXPECT_EQ(answer.status, 429);
  EXPECT_THAT(answer.body, StartsWith(ErrorOf("RESOURCE_EXHAUSTED", "TOO_MANY_READS")));
}

TEST_F(ApiTest, OnlyMethodsOfTheRoleTableWithOneRequestAreThere) {
  for (const char* path :
       {"/api/", "/api/x", "/api/sweepstake.v1.TelemetryService/StreamTelemetry",
        "/api/sweepstake.v1.PriorsService/ImportPriors", "/api/grpc.health.v1.Health/Check",
        "/api/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
        "/api/sweepstake.v1.PosteriorsService/listposteriors",
        "/api/sweepstake.v1.PosteriorsService.ListPosteriors",
        "/api/sweepstake.v1.PosteriorsService/ListPosteriors/",
        "/api//sweepstake.v1.PosteriorsService/ListPosteriors",
        "/api/../api/sweepstake.v1.PosteriorsService/ListPosteriors"}) {
    EXPECT_EQ(Post(path, "{}").status, 404) << path;
  }
  EXPECT_EQ(Get("/api/sweepstake.v1.PosteriorsService/ListPosteriors").status, 405);
  EXPECT_EQ(Post("/events/sweepstake.v1.PosteriorsService/WatchPosteriors", "{}").status, 405);
}

TEST_F(ApiTest, OtherMethodsAreRefusedWithThatOfThePath) {
  const std::pair<const char*, const char*> method_of[] = {
      {"/api/sweepstake.v1.PosteriorsService/ListPosteriors", "POST"},
      {"/api/whoami", "GET"},
      {"/events/sweepstake.v1.PosteriorsService/WatchPosteriors", "GET"},
      {"/logout", "POST"}};
  for (const auto& [path, method] : method_of) {
    const Answer answer = test_support::Exchange(
        http_->port(),
        absl::StrCat("PUT ", path, " HTTP/1.1\r\nHost: ", host_, "\r\nConnection: close\r\n\r\n"));
    EXPECT_EQ(answer.status, 405) << path;
    EXPECT_THAT(answer.head, HasSubstr(absl::StrCat("Allow: ", method, "\r\n"))) << path;
  }
}

TEST_F(ApiTest, EveryMethodOfTheRoleTableIsCalledOrWatched) {
  for (const rpc::Rpc& rpc : rpc::kRoleTable) {
    const std::string name(rpc.name);
    if (name == "TelemetryService/StreamTelemetry" || name == "PriorsService/ImportPriors")
      continue;  // their requests are streams
    const Answer answer = Call(name, "{}");
    if (name.find("/Watch") != std::string::npos) {
      EXPECT_EQ(answer.status, 404) << name;
      EXPECT_THAT(answer.body, HasSubstr("under /events/")) << name;
    } else {
      EXPECT_THAT(answer.body, Not(HasSubstr("under /events/"))) << name;
      EXPECT_THAT(answer.status, AnyOf(200, 400, 404)) << name << answer.body;
    }
  }
}

TEST_F(ApiTest, AClientThatLeavesEndsItsExport) {
  options_.max_transfers = 1;
  server_->Adjust(options_);
  // These are more records than the buffers of a connection can hold.
  for (int i = 0; i < 200; ++i) PutScene("scene " + std::to_string(i), 100);
  const std::string small = R"({"scene":"scene 7"})";
  {
    test_support::HttpSocket client(http_->port(), /*receive_bytes=*/4096);
    client.Send("POST /api/sweepstake.v1.PriorsService/ExportPriors HTTP/1.1\r\nHost: " + host_ +
                "\r\nX-Sweepstake: 1\r\nContent-Length: 2\r\n\r\n{}");
    client.ReadUntil("\"records\"");
    EXPECT_EQ(Call("PriorsService/ExportPriors", small).status, 429) << "the export is not over";
  }
  EXPECT_TRUE(
      rpc::Eventually([&] { return Call("PriorsService/ExportPriors", small).status == 200; }));
}

TEST_F(ApiTest, AnInvalidRequestIsRefused) {
  const std::string deep(100'000, '[');
  for (const std::string& body :
       {std::string("{"), std::string("[]"), std::string("7"), std::string("\"\""),
        std::string(R"({"nope":1})"), std::string(R"({"pageSize":"many"})"),
        std::string(R"({"pageSize":-1})"), std::string("{\"project\":\"\xff\"}"),
        std::string("{\"project\":\"\0\"}", 13), deep, R"({"project":)" + deep,
        std::string(R"({"project":"a"} trailing)")}) {
    const Answer answer = Call("PosteriorsService/ListPosteriors", body);
    EXPECT_EQ(answer.status, 400) << body.substr(0, 50);
    EXPECT_THAT(answer.body, StartsWith("{\"error\":{\"code\":\"INVALID_ARGUMENT\""));
  }
  EXPECT_EQ(Call("PosteriorsService/ListPosteriors", std::string(256 * 1024 + 1, ' ')).status, 413);
  EXPECT_EQ(Call("PosteriorsService/ListPosteriors", "{}").status, 200);
}

TEST_F(ApiTest, OtherSitesAreRefused) {
  const std::string list = "PosteriorsService/ListPosteriors";
  EXPECT_EQ(Call(list, "{}", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(Call(list, "{}", "Sec-Fetch-Site: cross-site\r\n").status, 403);
  EXPECT_EQ(Call(list, "{}", "Host: evil.example\r\n").status, 403);
  EXPECT_EQ(Call(list, "{}", "Origin: http://localhost\r\n").status, 200);
}

TEST_F(ApiTest, TheLogsHaveTheBrowsersAddress) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(rpc::HelloMessage()).session_id();
  EXPECT_EQ(Call("SessionsService/KickSession", R"({"sessionId":")" + id + "\"}").status, 200);
  EXPECT_THAT(logged_->text(),
              AllOf(HasSubstr("ipv4:127.0.0.1:"), HasSubstr("kicked session " + id)));
  // The row of the audit log is written only after the answer.
  std::string log;
  while (log.find("\"kicked session ") == std::string::npos)
    log =
        Dechunked(Call("AuditService/ExportDecisions", R"({"filter":{"sessionId":"admin"}})").body);
  EXPECT_THAT(log, HasSubstr("ipv4:127.0.0.1:"));
}

TEST_F(ApiTest, ReadsAreCountedForTheBrowser) {
  options_.max_reads_per_s = 1;
  server_->Adjust(options_);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(Call("PosteriorsService/ListPosteriors", "{}").status, 200) << i;
  const Answer answer = Call("PosteriorsService/ListPosteriors", "{}");
  EXPECT_EQ(answer.status, 429);
  EXPECT_THAT(answer.body, HasSubstr("the address ipv4:127.0.0.1 calls more often"));
}

class CsvTest : public ApiTest {
 protected:
  // Returns the answer to a request for a table.
  Answer Csv(const std::string& table, const std::string& request = "%7B%7D") {
    return Get("/csv/" + table + "?request=" + request);
  }
  static int64_t LinesOf(const Answer& answer) {
    const std::string text = Dechunked(answer.body);
    return std::count(text.begin(), text.end(), '\n');
  }
};

TEST_F(CsvTest, TheDecisionsOfASessionAreAFile) {
  TelemetryClient client(channel_);
  const std::string id = client.Open(rpc::HelloMessage()).session_id();
  for (int i = 1; i <= 3; ++i) Learn(client, i);
  const Answer answer =
      Csv("decisions", "%7B%22filter%22:%7B%22sessionId%22:%22" + id + "%22%7D%7D");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head, AllOf(HasSubstr("Content-Type: text/csv; charset=utf-8\r\n"),
                                 HasSubstr("Content-Disposition: attachment\r\n")));
  const std::string text = Dechunked(answer.body);
  EXPECT_THAT(text, StartsWith("time,project,scene,session,part,row,kind,"));
  EXPECT_THAT(text, HasSubstr(",game,harbour," + id + ",1,2,tick,1,"));
  EXPECT_EQ(LinesOf(answer), 1 + 4);
  EXPECT_EQ(
      LinesOf(Csv("decisions", "%7B%22filter%22:%7B%22kinds%22:[%22AUDIT_KIND_SETUP%22]%7D%7D")),
      1 + 1);
  EXPECT_EQ(LinesOf(Csv("windows")), 1 + 3);
  EXPECT_EQ(LinesOf(Csv("posteriors")), 1 + 3 * rpc::HelloMessage().arms_size());
  EXPECT_EQ(LinesOf(Csv("sessions")), 1 + 1);
  EXPECT_EQ(LinesOf(Csv("logs")), 1 + 1);
}

TEST_F(CsvTest, ATableHasTheRowsOfAllPages) {
  for (int i = 0; i < 250; ++i) PutScene("scene " + std::to_string(i), 1);
  const std::string text = Dechunked(Csv("scenes").body);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 250);
  for (const int i : {0, 99, 100, 101, 199, 249})
    EXPECT_THAT(text, HasSubstr(",scene " + std::to_string(i) + ",")) << i;
  EXPECT_EQ(LinesOf(Csv("scenes", "%7B%22scene%22:%22scene+7%22%7D")), 1 + 1);
  EXPECT_EQ(LinesOf(Csv("evidence")), 1 + 250);
}

TEST_F(CsvTest, AnEmptyTableHasItsHeader) {
  for (const char* table :
       {"decisions", "windows", "posteriors", "logs", "scenes", "sessions", "evidence"}) {
    const Answer answer = Csv(table);
    EXPECT_EQ(answer.status, 200) << table;
    EXPECT_EQ(LinesOf(answer), 1) << table;
  }
}

TEST_F(CsvTest, AnErrorBeforeTheFirstLineHasItsStatus) {
  EXPECT_EQ(Csv("nothing").status, 404);
  EXPECT_EQ(Csv("decisions", "%7B").status, 400);
  EXPECT_EQ(Csv("scenes", "%7B%22pageToken%22:%22x%22%7D").status, 400);
  EXPECT_EQ(Post("/csv/scenes", "{}").status, 405);
  options_.max_transfers = 0;
  server_->Adjust(options_);
  EXPECT_EQ(Csv("decisions").status, 429);
}

TEST_F(CsvTest, AnErrorAfterTheFirstPageLeavesTheFileIncomplete) {
  options_.max_reads_per_s = 1;  // the burst is ten reads
  server_->Adjust(options_);
  for (int i = 0; i < 1'100; ++i) PutScene("scene " + std::to_string(i), 1);
  const Answer answer = Csv("scenes");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.body, Not(::testing::EndsWith("0\r\n\r\n")));
}

TEST_F(ApiTokensTest, CsvNeedsARole) {
  EXPECT_EQ(Get("/csv/decisions").status, 401);
  EXPECT_EQ(Get("/csv/scenes").status, 401);
}

TEST_F(ApiTest, ADrainedServerIsUnavailable) {
  server_->Drain(std::chrono::milliseconds(0));
  EXPECT_EQ(Call("PosteriorsService/ListPosteriors", "{}").status, 503);
  EXPECT_EQ(Get("/events/sweepstake.v1.PosteriorsService/WatchPosteriors").status, 503);
}

TEST_F(ApiTokensTest, RolesAndProjectsAreThoseOfGrpc) {
  const std::string list = "PosteriorsService/ListPosteriors";
  EXPECT_EQ(Call(list, "{}").status, 401);
  EXPECT_THAT(Call(list, "{}").body, StartsWith(ErrorOf("UNAUTHENTICATED", "TOKEN_MISSING")));
  EXPECT_THAT(Call(list, "{}", Bearer("nobodys-token")).body,
              StartsWith(ErrorOf("UNAUTHENTICATED", "TOKEN_REFUSED")));
  EXPECT_EQ(Call(list, "{}", Bearer("game-token")).status, 403);
  EXPECT_EQ(Call(list, "{}", Bearer("ann-token")).status, 200);
  EXPECT_EQ(Call(list, "{}", Bearer("root-token")).status, 200);
  EXPECT_EQ(Call("SessionsService/KickSession", R"({"sessionId":"x"})", Bearer("ann-token")).status,
            403);
  EXPECT_EQ(
      Call("SessionsService/KickSession", R"({"sessionId":"x"})", Bearer("mine-token")).status,
      404);
  EXPECT_EQ(Call(list, R"({"project":"theirs"})", Bearer("mine-token")).status, 403);
  EXPECT_EQ(Call(list, R"({"project":"mine"})", Bearer("mine-token")).status, 200);
  EXPECT_EQ(Get("/events/sweepstake.v1.SessionsService/WatchSessions", Bearer("game-token")).status,
            403);
}

TEST_F(ApiTokensTest, AnImpossibleTokenIsRefused) {
  for (const std::string& token :
       {std::string("a b"), std::string("\x80"), std::string("\x7f"), std::string(300, 'a')}) {
    EXPECT_EQ(Call("PosteriorsService/ListPosteriors", "{}", Bearer(token)).status, 400) << token;
  }
}

}  // namespace
}  // namespace sweepstake::server
