// The HTTP side of a real server of the services, over loopback, connected as in the daemon.
#pragma once

#include <google/protobuf/util/json_util.h>

#include <memory>
#include <string>
#include <utility>

#include "server/daemon_site.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/http_exchange.h"

namespace sweepstake::server {

inline std::string JsonOf(const google::protobuf::Message& message) {
  std::string json;
  EXPECT_TRUE(google::protobuf::util::MessageToJsonString(message, &json).ok());
  return json;
}

class ApiTest : public rpc::RpcTest {
 protected:
  using Answer = test_support::HttpAnswer;

  void SetUp() override {
    RpcTest::SetUp();
    StartHttp();
  }
  void TearDown() override {
    http_.reset();
    RpcTest::TearDown();
  }
  void StartHttp() {
    web::ApiOptions api = ApiOf(*server_);
    api.event_counters = events_;
    api.events = event_limits_;
    auto http = web::HttpServer::Start("127.0.0.1:0", MakeSite(std::move(api), {}, {}), /*tls=*/{},
                                       limits_);
    ASSERT_TRUE(http.ok()) << http.status();
    http_ = *std::move(http);
  }

  // `more` are further headers, each with its line end.
  Answer Post(const std::string& path, const std::string& body, const std::string& more = "") {
    return test_support::Exchange(http_->port(), "POST " + path + " HTTP/1.1\r\nHost: " + host_ +
                                                     "\r\nConnection: close\r\nX-Sweepstake: "
                                                     "1\r\nContent-Length: " +
                                                     std::to_string(body.size()) + "\r\n" + more +
                                                     "\r\n" + body);
  }
  Answer Call(const std::string& method, const std::string& body, const std::string& more = "") {
    return Post("/api/sweepstake.v1." + method, body, more);
  }
  Answer Get(const std::string& target, const std::string& more = "") {
    return test_support::Exchange(http_->port(), "GET " + target + " HTTP/1.1\r\nHost: " + host_ +
                                                     "\r\nConnection: close\r\n" + more + "\r\n");
  }
  static std::string Bearer(const std::string& token) {
    return "Authorization: Bearer " + token + "\r\n";
  }
  // Sends frames of a game as message `sequence`, which adds evidence to the scene.
  void Learn(rpc::TelemetryClient& client, uint64_t sequence) {
    client.Send(rpc::Frames(sequence, 30));
    EXPECT_TRUE(Applied(++learnt_));
    Tick();
    client.AwaitAcknowledgement(sequence);
  }
  // Puts evidence of a source into the store without the server.
  void PutScene(const std::string& scene, int arm_count = 1) {
    std::vector<priors::PriorRecord> records;
    for (int arm = 0; arm < arm_count; ++arm) {
      records.push_back(rpc::LearntInHours());
      records.back().key.scene = scene;
      records.back().key.arm = std::to_string(arm) + std::string(100, 'x');
    }
    Put(records);
  }

  Config config_;
  web::HttpLimits limits_{.patience = std::chrono::minutes(10)};
  // The interval is so long that no heartbeats are sent. Their comments between the events would
  // change the expected text.
  web::EventLimits event_limits_{.heartbeat = std::chrono::minutes(10)};
  const std::shared_ptr<web::EventCounters> events_ = std::make_shared<web::EventCounters>();
  std::unique_ptr<web::HttpServer> http_;
  std::string host_ = "localhost";  // the Host of requests
  uint64_t learnt_ = 0;
};

// Adds tokens NAME-token with these names and roles: game (ingest), ann (watch), mine (operator of
// the projects game and mine), root (admin).
class ApiTokensTest : public ApiTest {
 protected:
  ApiTokensTest() {
    options_.tokens = &tokens_;
    tokens_.Add("game", auth::Role::kIngest);
    tokens_.Add("ann", auth::Role::kWatch);
    tokens_.Add("mine", auth::Role::kOperator, {"game", "mine"});
    tokens_.Add("root", auth::Role::kAdmin);
  }
  // Returns the header with the cookie of the login.
  std::string LogIn(const std::string& token) {
    const Answer answer = Post("/login", "{\"token\":\"" + token + "\"}");
    EXPECT_EQ(answer.status, 204) << answer.body;
    const size_t start = answer.head.find("sweepstake");
    return "Cookie: other=1; " + answer.head.substr(start, answer.head.find(';', start) - start) +
           "\r\n";
  }

  rpc::ScriptedTokens tokens_;
};

}  // namespace sweepstake::server
