// Kills two daemons with kill -9 again and again, at seeded moments of their progress. Each daemon
// has its own data directory and games, and restarts on its port.
//
// TEST_KILLS and TEST_SEED set the number of kills and the seed. A seed does not repeat a failure
// exactly, because the scheduler affects what is in progress at a kill.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "tests/end_to_end/scripted_game.h"
#include "tests/end_to_end/store_reader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/size_of_run.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::Ge;

constexpr size_t kGameCount = 3;  // concurrent games of each daemon
// A "life" is the time between two kills of a daemon. A daemon counts at most 16 bail-outs of a
// session at once. Therefore a life has at most two bail-outs, and at least every fourth life lasts
// until the daemon has all evidence.
constexpr uint64_t kLivesUntilAllIsHeard = 4;
constexpr uint64_t kMaxBailOutsInLife = 2;

struct Player {
  std::unique_ptr<ScriptedGame> game;
  uint64_t bail_out_count = 0;
  uint64_t bail_outs_in_life = 0;
  uint64_t sent_before_life = 0;        // number of messages
  priors::SourceProgress on_disk = {};  // progress in the store at the last check
};

// Returns whether the current daemon has put evidence of the game on its disk.
bool IsHeard(const Player& player) {
  return player.game->stats().acknowledged_sequence > player.sent_before_life;
}

// The counts of a game that has ended with a goodbye.
struct Sent {
  SessionStats stats;
  uint64_t bail_out_count = 0;
};

// A daemon and its games.
class Household {
 public:
  explicit Household(uint64_t seed)
      : random_(seed), daemon_(std::make_unique<DaemonProcess>(data_.path())) {
    for (size_t i = 0; i < kGameCount; ++i) players_.push_back(NewPlayer());
  }

  // Runs until some evidence is on disk and more is in progress, kills the daemon and starts
  // another one.
  void LiveAndDie(uint64_t life);
  // Ends all games and the daemon, and compares what was sent with the content of the store.
  void End();

 private:
  uint64_t Draw(uint64_t max) { return std::uniform_int_distribution<uint64_t>(0, max)(random_); }
  Player NewPlayer() {
    return {.game = std::make_unique<ScriptedGame>(daemon_->address(), FastOptions())};
  }

  template <typename Done>
  void PlayUntil(Done done);
  // Runs until `count` more messages are acknowledged or sent.
  void PlayFor(uint64_t SessionStats::*messages, uint64_t count);
  void BailOut(Player& player);
  void SayGoodbye(Player& player);
  void Kill();
  void LookAtDisk(Player& player, const SessionStats& at_kill);

  const TemporaryDirectory data_;
  std::mt19937_64 random_;
  std::unique_ptr<DaemonProcess> daemon_;
  std::vector<Player> players_;
  std::vector<Sent> gone_;
};

template <typename Done>
void Household::PlayUntil(Done done) {
  while (!done()) {
    bool ran = false;
    for (Player& player : players_) {
      if (Draw(200) == 0 && player.bail_outs_in_life < kMaxBailOutsInLife) BailOut(player);
      ran |= player.game->RunSomeFrames();
    }
    // Leave the processors to the daemons while they work.
    if (!ran) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
}

void Household::PlayFor(uint64_t SessionStats::*messages, uint64_t count) {
  const auto sum = [&] {
    uint64_t total = 0;
    for (const Player& player : players_) total += player.game->stats().*messages;
    return total;
  };
  const uint64_t goal = sum() + count;
  PlayUntil([&] { return sum() >= goal; });
}

void Household::BailOut(Player& player) {
  player.game->BailOut();
  ++player.bail_out_count;
  ++player.bail_outs_in_life;
}

void Household::SayGoodbye(Player& player) {
  // Without a connection, the game would end without a goodbye. So wait for an acknowledgement.
  PlayUntil([&] { return IsHeard(player); });
  player.game->Stop(/*deadline_ms=*/60'000);
  gone_.push_back({.stats = player.game->stats(), .bail_out_count = player.bail_out_count});
  EXPECT_EQ(gone_.back().stats.acknowledged_sequence, gone_.back().stats.sent_sequence)
      << "goodbye waits for the disk: " << gone_.back().stats.last_error;
  EXPECT_EQ(player.game->wait_count(), 0U) << "the frame thread must never wait";
}

void Household::LiveAndDie(uint64_t life) {
  PlayFor(&SessionStats::acknowledged_sequence, Draw(80));
  if (life % kLivesUntilAllIsHeard == 0) {
    PlayUntil([this] { return std::all_of(players_.begin(), players_.end(), IsHeard); });
  }
  if (Draw(7) == 0) {
    Player& player = players_[Draw(kGameCount - 1)];
    SayGoodbye(player);
    player = NewPlayer();
  }
  PlayFor(&SessionStats::sent_sequence, Draw(20));
  Kill();
  for (Player& player : players_) {
    player.game->RunFrames(Draw(500));  // The frames continue without a daemon.
    if (Draw(3) == 0) BailOut(player);
  }
  daemon_ = std::make_unique<DaemonProcess>(data_.path(), daemon_->address());
}

void Household::Kill() {
  std::vector<SessionStats> before;
  for (const Player& player : players_) before.push_back(player.game->stats());
  daemon_->Kill();
  // Reading the store also compacts its log. In half of the cases, leave this to the next
  // daemon.
  const bool look = Draw(1) == 0;
  for (size_t i = 0; i < kGameCount; ++i) {
    Player& player = players_[i];
    player.bail_outs_in_life = 0;
    player.sent_before_life = player.game->stats().sent_sequence;
    if (look && before[i].acknowledged_sequence > 0) LookAtDisk(player, before[i]);
  }
}

void Household::LookAtDisk(Player& player, const SessionStats& at_kill) {
  const priors::SourceState source = ReadSource(data_.path(), at_kill.session_id);
  EXPECT_THAT(source.progress.message_sequence, Ge(at_kill.acknowledged_sequence));
  EXPECT_THAT(source.progress.commit_sequence, Ge(player.on_disk.commit_sequence));
  ExpectConsistent(source);
  player.on_disk = source.progress;
}

void Household::End() {
  for (Player& player : players_) SayGoodbye(player);
  EXPECT_EQ(daemon_->Terminate(), 0);
  priors::Evidence of_sessions;
  for (const Sent& sent : gone_) {
    const priors::SourceState source = ReadSource(data_.path(), sent.stats.session_id);
    ExpectConsistent(source);
    EXPECT_EQ(source.progress.message_sequence, sent.stats.sent_sequence);
    EXPECT_EQ(source.progress.frame_count, sent.stats.sent_frame_count)
        << "every frame that was sent is in the store, once";
    EXPECT_EQ(sent.stats.dropped_frame_count, 0U);
    EXPECT_EQ(TotalEvidence(source).bail_out_count, sent.bail_out_count);
    of_sessions += TotalEvidence(source);
  }
  const std::vector<priors::SceneEvidence> scenes = ReadScenes(data_.path());
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0].source_count, gone_.size()) << "no game has left a session behind";
  priors::Evidence of_scene;
  for (const auto& arm : scenes[0].arms) (of_scene += arm.live) += arm.lane;
  EXPECT_EQ(of_scene.window_count, of_sessions.window_count);
  EXPECT_EQ(of_scene.bail_out_count, of_sessions.bail_out_count);
  EXPECT_NEAR(of_scene.alpha + of_scene.beta, of_sessions.alpha + of_sessions.beta, 1e-6);
}

TEST(KillLoopTest, DaemonsKilledAtAnyMomentLoseNothingAcknowledgedAndCountNothingTwice) {
  const uint64_t kills = FromEnvironment("TEST_KILLS", 100);
  const uint64_t seed = FromEnvironment("TEST_SEED", 1);
  SCOPED_TRACE(testing::Message() << "TEST_SEED=" << seed);
  const auto live = [](uint64_t household_seed, uint64_t kill_count) {
    Household household(household_seed);
    for (uint64_t life = 0; life < kill_count; ++life) household.LiveAndDie(life);
    household.End();
  };
  std::thread second(live, 2 * seed + 1, kills / 2);
  live(2 * seed, kills - kills / 2);
  second.join();
}

}  // namespace
}  // namespace sweepstake::test_support
