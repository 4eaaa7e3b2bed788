// Tests three daemons on one PostgreSQL, with games that move between them. Daemons and servers are
// killed at seeded moments. In the end each message of each game must count once.
//
// TEST_KILLS and TEST_SEED set the number of kills and the seed. A seed does not repeat a failure
// exactly, because the scheduler affects what is in progress at a kill.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "server/storage/outbox/outbox.h"
#include "server/storage/postgres/postgres_prior_store.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/end_to_end/store_reader.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/postgres/postgres_server.h"
#include "tests/support/size_of_run.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

constexpr size_t kDaemons = 3;
constexpr size_t kGames = 4;
constexpr int kFramesPerMessage = 30;
// An hour of a game with slow frames: 150 messages of 240 frames of 100 ms.
constexpr int kMessagesPerHour = 150;
constexpr int kFramesOfHour = 240;
constexpr uint64_t kFrameMsOfHour = 100;
constexpr uint64_t kMaxBailOuts = 12;  // a daemon accepts 16 of a session at once

std::shared_ptr<grpc::Channel> ChannelTo(const std::string& address) {
  // Do not share an earlier channel's connection, which may have failed.
  grpc::ChannelArguments alone;
  alone.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), alone);
}

// A game that keeps unacknowledged messages, and sends them to the daemon that it uses next.
class Game {
 public:
  explicit Game(const std::string& scene) : hello_(rpc::OneArmHello()) {
    hello_.set_time_scale(200);
    hello_.set_scene(scene);
  }

  // Leaves its daemon without a goodbye, and tries to continue at the daemon with this address.
  void MoveTo(const std::string& address);
  void Send(bool bails_out);
  // Sends an hour's frames without waiting for an answer.
  void SendHour();
  // Reads until everything sent is acknowledged, or the stream ends.
  void Await();
  // Returns whether the daemon has confirmed the goodbye.
  bool SayGoodbye();

  bool connected() const { return stream_ != nullptr; }
  const std::string& session_id() const { return hello_.session_id(); }
  uint64_t sent_count() const { return sent_.size(); }
  uint64_t bail_out_count() const { return bail_out_count_; }
  // Compares what was sent with the content of the store.
  void ExpectAllIn(priors::PriorReader& store) const;

 private:
  std::optional<v1::StreamTelemetryResponse> Read();

  v1::Hello hello_;
  std::unique_ptr<rpc::TelemetryClient> stream_;
  std::vector<v1::StreamTelemetryRequest> sent_;  // message i has the sequence number i + 1
  uint64_t acknowledged_ = 0;
  uint64_t frame_count_ = 0;
  uint64_t bail_out_count_ = 0;
};

std::optional<v1::StreamTelemetryResponse> Game::Read() {
  auto response = stream_->Read();
  if (!response) stream_.reset();
  if (response && response->has_acknowledgement())
    acknowledged_ = std::max(acknowledged_, response->acknowledgement().sequence());
  return response;
}

void Game::MoveTo(const std::string& address) {
  stream_ = std::make_unique<rpc::TelemetryClient>(ChannelTo(address));
  stream_->Send(rpc::Request(hello_));
  const auto response = Read();
  if (!response) return;
  ASSERT_TRUE(response->has_welcome());
  const v1::Welcome& welcome = response->welcome();
  if (acknowledged_ > 0) {
    EXPECT_EQ(welcome.session_id(), hello_.session_id()) << "the session is lost";
  }
  rpc::Resume(hello_, welcome);
  // The daemon may have read the session before another daemon stored messages. It then reports a
  // smaller number, but the game does not resend acknowledged messages. The daemon must detect that
  // its copy of the session is outdated.
  acknowledged_ = std::max(acknowledged_, welcome.acknowledged_sequence());
  for (uint64_t next = acknowledged_; next < sent_.size(); ++next) stream_->Send(sent_[next]);
}

void Game::Send(bool bails_out) {
  const uint64_t sequence = sent_.size() + 1;
  if (bails_out && bail_out_count_ < kMaxBailOuts) {
    ++bail_out_count_;
    sent_.push_back(rpc::BailOut(sequence, sequence * 1000));
  } else {
    frame_count_ += kFramesPerMessage;
    sent_.push_back(rpc::Frames(sequence, kFramesPerMessage));
  }
  if (stream_ != nullptr) stream_->Send(sent_.back());
}

void Game::SendHour() {
  for (int i = 0; i < kMessagesPerHour; ++i) {
    frame_count_ += kFramesOfHour;
    sent_.push_back(rpc::Frames(sent_.size() + 1, kFramesOfHour, kFrameMsOfHour));
    stream_->Send(sent_.back());
  }
}

void Game::Await() {
  while (stream_ != nullptr && acknowledged_ < sent_.size()) Read();
}

bool Game::SayGoodbye() {
  if (stream_ == nullptr) return false;
  stream_->Send(rpc::Goodbye());
  const bool confirmed = stream_->Finish().ok();
  stream_.reset();
  return confirmed;
}

void Game::ExpectAllIn(priors::PriorReader& store) const {
  const auto source = store.LoadSource(session_id());
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_TRUE(source->has_value());
  EXPECT_EQ((*source)->progress.message_sequence, sent_.size());
  EXPECT_EQ((*source)->progress.frame_count, frame_count_);
  EXPECT_EQ(TotalEvidence(**source).bail_out_count, bail_out_count_);
  ExpectConsistent(**source);
}

// Returns the posteriors after all sessions at the daemon have ended.
v1::ListPosteriorsResponse PosteriorsOf(const DaemonProcess& daemon) {
  const auto stub = v1::PosteriorsService::NewStub(ChannelTo(daemon.address()));
  v1::ListPosteriorsResponse response;
  const auto is_quiet = [](const v1::ScenePosterior& scene) {
    return scene.active_session_count() == 0;
  };
  EXPECT_TRUE(rpc::Eventually([&] {
    grpc::ClientContext context;
    return stub->ListPosteriors(&context, {}, &response).ok() &&
           std::all_of(response.scenes().begin(), response.scenes().end(), is_quiet);
  }));
  return response;
}

class Cluster {
 public:
  explicit Cluster(uint64_t seed) : random_(seed), url_(server_.NewDatabase()) {
    for (size_t i = 0; i < kDaemons; ++i) daemons_.push_back(Begin(i, "127.0.0.1:0"));
    for (size_t i = 0; i < kGames; ++i) games_.emplace_back("scene " + std::to_string(i % 2));
  }

  uint64_t Draw(uint64_t count) { return random_() % count; }
  void Play();
  // Kills a daemon or the server, and starts it again.
  void Kill();
  // Stops the server, runs each game for an hour of its time, and starts the server again.
  void PlayWithoutServer();
  // Ends all games, and compares.
  void End();

 private:
  std::unique_ptr<DaemonProcess> Begin(size_t i, const std::string& listen) {
    return std::make_unique<DaemonProcess>(data_[i].path(), listen,
                                           std::vector<std::string>{"--store", url_});
  }
  const std::string& AnyAddress() { return daemons_[Draw(kDaemons)]->address(); }
  void ExpectTheSameEverywhere(priors::PriorStore& store);

  std::mt19937_64 random_;
  PostgresServer server_;
  const std::string url_;
  const TemporaryDirectory data_[kDaemons];
  std::vector<std::unique_ptr<DaemonProcess>> daemons_;
  std::vector<Game> games_;
};

void Cluster::Play() {
  Game& game = games_[Draw(kGames)];
  if (!game.connected() || Draw(4) == 0) game.MoveTo(AnyAddress());
  for (uint64_t count = 1 + Draw(5); count > 0; --count) game.Send(Draw(10) == 0);
  if (Draw(2) == 0) game.Await();
}

void Cluster::Kill() {
  if (Draw(3) == 0) {
    server_.Kill();
    for (uint64_t count = Draw(3); count > 0; --count) games_[Draw(kGames)].Send(false);
    return server_.Start();
  }
  std::unique_ptr<DaemonProcess>& daemon = daemons_[Draw(kDaemons)];
  const std::string address = daemon->address();
  const auto i = static_cast<size_t>(&daemon - daemons_.data());
  daemon->Kill();
  daemon.reset();
  daemon = Begin(i, address);
}

void Cluster::PlayWithoutServer() {
  for (Game& game : games_) {
    while (!game.connected()) game.MoveTo(AnyAddress());
  }
  server_.Kill();
  for (Game& game : games_) game.SendHour();
  for (int i = 0; i < 50; ++i) games_[Draw(kGames)].Send(Draw(20) == 0);
  for (Game& game : games_) EXPECT_TRUE(game.connected());
  server_.Start();
  for (Game& game : games_) game.Await();
}

void Cluster::End() {
  for (Game& game : games_) {
    do {
      game.MoveTo(AnyAddress());
      game.Await();
    } while (!game.SayGoodbye());
  }
  const auto store = storage::OpenPostgresPriorStore(url_);
  ASSERT_TRUE(store.ok()) << store.status();
  for (const Game& game : games_) game.ExpectAllIn(**store);
  ExpectTheSameEverywhere(**store);
  for (const auto& daemon : daemons_) EXPECT_EQ(daemon->Terminate(), 0);
}

// Expects that stored sums equal the sums of the sources' evidence to the bit, on every daemon.
void Cluster::ExpectTheSameEverywhere(priors::PriorStore& store) {
  std::map<priors::EvidenceKey, priors::Evidence> sums;
  for (const Game& game : games_) {
    const auto source = store.LoadSource(game.session_id());
    ASSERT_TRUE(source.ok()) << source.status();
    ASSERT_TRUE(source->has_value());
    for (const auto& [key, evidence] : (*source)->evidence) sums[key] += evidence;
  }
  for (const auto& [key, sum] : sums) {
    const auto scene =
        store.LoadScene({key.project, key.scene, key.machine_class, key.reward_version});
    ASSERT_TRUE(scene.ok()) << scene.status();
    ASSERT_TRUE(scene->has_value());
    EXPECT_EQ((*scene)->source_count, kGames / 2);
    EXPECT_EQ((*scene)->arms.at(0).live, sum);
  }
  std::vector<std::string> said;
  for (const auto& daemon : daemons_) {
    const v1::ListPosteriorsResponse response = PosteriorsOf(*daemon);
    EXPECT_EQ(response.scenes_size(), static_cast<int>(sums.size()));
    said.push_back(response.SerializeAsString());
  }
  EXPECT_EQ(said[1], said[0]);
  EXPECT_EQ(said[2], said[0]);
}

TEST(SeveralDaemons, EachMessageOfEachGameCountsOnceAfterAnyKill) {
  const uint64_t seed = FromEnvironment("TEST_SEED", 20'260'115);
  const uint64_t kills = FromEnvironment("TEST_KILLS", 100);
  SCOPED_TRACE("TEST_SEED=" + std::to_string(seed));
  Cluster cluster(seed);
  for (uint64_t kill = 0; kill < kills && !::testing::Test::HasFailure(); ++kill) {
    for (uint64_t count = 1 + cluster.Draw(3); count > 0; --count) cluster.Play();
    cluster.Kill();
  }
  cluster.End();
}

TEST(SeveralDaemons, GamesContinueForHoursWithoutTheServerAndAllEvidenceCountsOnce) {
  Cluster cluster(7);
  for (int i = 0; i < 3; ++i) cluster.PlayWithoutServer();
  cluster.End();
}

// In this test no game resends its evidence.
TEST(SeveralDaemons, EvidenceSurvivesADaemonThatEndsWithoutTheServer) {
  for (const bool is_killed : {false, true}) {
    PostgresServer server;
    const std::string url = server.NewDatabase();
    const TemporaryDirectory data;
    const auto begin = [&] {
      return std::make_unique<DaemonProcess>(data.path(), "127.0.0.1:0",
                                             std::vector<std::string>{"--store", url});
    };
    auto daemon = begin();
    Game game("harbour");
    game.MoveTo(daemon->address());
    game.Send(true);
    game.Await();
    server.Kill();
    game.SendHour();
    const auto outbox = data.path() / "outbox.db";
    const auto kept = [&] {
      uint64_t messages = 0;
      const std::vector<priors::SourceUpdate> updates =
          storage::Outbox::Open(outbox).value().Load().value();
      for (const priors::SourceUpdate& update : updates)
        messages = std::max(messages, update.progress.message_sequence);
      return messages;
    };
    if (is_killed) {
      EXPECT_TRUE(rpc::Eventually([&] { return kept() == game.sent_count(); }));
      daemon->Kill();
    } else {
      EXPECT_TRUE(rpc::Eventually([&] { return kept() > 1; }))
          << "the daemon has received the hour";
      EXPECT_EQ(daemon->Terminate(), 0);
      EXPECT_EQ(kept(), game.sent_count());
    }
    server.Start();
    daemon = begin();
    EXPECT_EQ(kept(), 0u);
    EXPECT_EQ(daemon->Terminate(), 0);
    const auto store = storage::OpenPostgresPriorStore(url);
    ASSERT_TRUE(store.ok()) << store.status();
    game.ExpectAllIn(**store);
  }
}

TEST(SeveralDaemons, WatchersOfOneDaemonSeeTheEvidenceOfGamesOfAnother) {
  PostgresServer server;
  const std::vector<std::string> store = {"--store", server.NewDatabase()};
  const TemporaryDirectory data[2];
  const DaemonProcess watched(data[0].path(), "127.0.0.1:0", store);
  const DaemonProcess played(data[1].path(), "127.0.0.1:0", store);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  const auto stub = v1::PosteriorsService::NewStub(ChannelTo(watched.address()));
  const auto stream = stub->WatchPosteriors(&context, {});
  Game game("harbour");
  game.MoveTo(played.address());
  for (uint64_t bail_outs = 1; bail_outs <= 3; ++bail_outs) {
    game.Send(true);
    game.Await();
    v1::WatchPosteriorsResponse response;
    while (response.posterior().arms_size() == 0 ||
           response.posterior().arms(0).bail_out_count() < bail_outs)
      ASSERT_TRUE(stream->Read(&response)) << stream->Finish().error_message();
  }
  context.TryCancel();
}

}  // namespace
}  // namespace sweepstake::test_support
