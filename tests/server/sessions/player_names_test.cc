// Tests what games with a token of the role `player` can add to the store: evidence about the arms
// that others have used in a scene. Players who invent names neither store them nor use up quotas.
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "server/sessions/session_start.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/rpc/services/prompt_daemon.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;

class PlayerNamesTest : public ::testing::Test {
 protected:
  // Plays a session with a bail-out of its active arm. Returns whether it was welcomed.
  bool Play(auth::Role role, const v1::Hello& hello, const std::string& network = "203.0.113") {
    auth::Principal caller;
    caller.token_id = 7;
    caller.role = role;
    PromptStream stream(daemon_, "ipv4:" + network + ".7:1", caller);
    stream.Send(Request(hello));
    stream.Send(BailOut(1, 1));
    stream.Send(Goodbye());
    daemon_.Advance(10 * kSecondNs);  // below the rate of bail-outs that count
    return stream.welcomed();
  }
  static v1::Hello HelloWithArm(const std::string& arm, uint32_t version = 1) {
    v1::Hello hello = OneArmHello();
    hello.mutable_arms(0)->set_name(arm);
    hello.mutable_arms(0)->set_backend_version(version);
    return hello;
  }
  static v1::Hello HelloOfClass(const std::string& machine_class) {
    v1::Hello hello = OneArmHello();
    hello.set_machine_class(machine_class);
    return hello;
  }
  // Returns how often the scene's arm has bailed out, over all machine classes.
  uint64_t BailOuts(const std::string& arm, const std::string& scene = "harbour") {
    uint64_t count = 0;
    const auto scenes = daemon_.store.store.List({"game", scene}, std::nullopt, 100).value();
    for (const auto& stored : scenes) {
      for (const auto& of_scene : stored.arms)
        count += of_scene.name == arm ? of_scene.live.bail_out_count : 0;
    }
    return count;
  }
  uint64_t SceneCount() { return daemon_.store.store.CountScenes("game")->names; }

  PromptDaemon daemon_;
};

TEST_F(PlayerNamesTest, APlayersEvidenceCountsOnceTheStudioHasUsedTheArm) {
  EXPECT_TRUE(Play(auth::Role::kPlayer, OneArmHello()));
  EXPECT_EQ(SceneCount(), 0u);
  EXPECT_TRUE(Play(auth::Role::kIngest, OneArmHello()));
  EXPECT_EQ(BailOuts("Grid"), 1u);
  EXPECT_TRUE(Play(auth::Role::kPlayer, OneArmHello()));
  EXPECT_EQ(BailOuts("Grid"), 2u);
}

TEST_F(PlayerNamesTest, ImportedEvidenceMakesAnArmKnown) {
  const priors::PriorRecord record = LearntInHours();
  ASSERT_TRUE(daemon_.store.store.Import({&record, 1}).ok());
  EXPECT_TRUE(Play(auth::Role::kPlayer, OneArmHello()));
  EXPECT_EQ(BailOuts("Grid"), 1u);
}

TEST_F(PlayerNamesTest, InventedArmsTakeNoPlaces) {
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello()));
  for (int i = 0; i < 40; ++i) {
    const std::string arm = "invented " + std::to_string(i);
    EXPECT_TRUE(Play(auth::Role::kPlayer, HelloWithArm(arm))) << "it decides, but stores nothing";
    EXPECT_EQ(BailOuts(arm), 0u);
    EXPECT_TRUE(Play(auth::Role::kPlayer, HelloWithArm("Grid", 1'000 + i)));
  }
  EXPECT_EQ(BailOuts("Grid"), 1u) << "not of invented versions";
  EXPECT_TRUE(Play(auth::Role::kIngest, HelloWithArm("MyBvh")));
  EXPECT_TRUE(Play(auth::Role::kPlayer, HelloWithArm("MyBvh"), "198.51.100"));
  EXPECT_EQ(BailOuts("MyBvh"), 2u);
}

TEST_F(PlayerNamesTest, InventedScenesTakeNoPlaces) {
  daemon_.options.max_scenes = 3;
  for (int i = 0; i < 10; ++i) {
    v1::Hello hello = OneArmHello();
    hello.set_scene("invented " + std::to_string(i));
    EXPECT_TRUE(Play(auth::Role::kPlayer, hello));
  }
  EXPECT_EQ(SceneCount(), 0u);
  for (const char* scene : {"a", "b", "c"}) {
    v1::Hello hello = OneArmHello();
    hello.set_scene(scene);
    EXPECT_TRUE(Play(auth::Role::kIngest, hello));
    EXPECT_TRUE(Play(auth::Role::kPlayer, hello));
    EXPECT_EQ(BailOuts("Grid", scene), 2u);
  }
}

TEST_F(PlayerNamesTest, APlayerAddsFewMachineClassesAndOthersAddTheirs) {
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello(), "192.0.2"));
  for (int i = 0; i < 20; ++i)
    EXPECT_TRUE(Play(auth::Role::kPlayer, HelloOfClass("invented " + std::to_string(i))));
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->keys, 1 + priors::kMaxScenesOfParty);
  EXPECT_TRUE(Play(auth::Role::kPlayer, HelloOfClass("laptop"), "198.51.100"));
  EXPECT_TRUE(Play(auth::Role::kPlayer, HelloOfClass("laptop"))) << "a class that exists";
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->keys, 2 + priors::kMaxScenesOfParty);
  EXPECT_EQ(BailOuts("Grid"), 1 + priors::kMaxScenesOfParty + 2);
}

TEST_F(PlayerNamesTest, OnTheDaemonsMachineTheTokenIsTheParty) {
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello(), "127.0.0"));
  for (int i = 0; i < 20; ++i)
    EXPECT_TRUE(
        Play(auth::Role::kPlayer, HelloOfClass("invented " + std::to_string(i)), "127.0.0"));
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->keys, 1 + priors::kMaxScenesOfParty);
  EXPECT_EQ(daemon_.store.losses().player_increment_count, 20 - priors::kMaxScenesOfParty);
}

// None of these sessions has evidence when the others begin.
TEST_F(PlayerNamesTest, SimultaneousSessionsAddNoMoreMachineClasses) {
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello(), "192.0.2"));
  auth::Principal caller;
  caller.token_id = 7;
  caller.role = auth::Role::kPlayer;
  std::vector<std::unique_ptr<PromptStream>> streams;
  for (int i = 0; i < 10; ++i) {
    streams.push_back(std::make_unique<PromptStream>(daemon_, "ipv4:203.0.113.7:1", caller));
    streams.back()->Send(Request(HelloOfClass("invented " + std::to_string(i))));
  }
  for (const auto& stream : streams) {
    stream->Send(BailOut(1, 1));
    stream->Send(Goodbye());
  }
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->keys, 1 + priors::kMaxScenesOfParty);
}

TEST_F(PlayerNamesTest, SilentSessionsUseUpNoQuota) {
  daemon_.options.max_scenes = 1;
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello(), "192.0.2"));
  auth::Principal caller;
  caller.role = auth::Role::kPlayer;
  std::vector<std::unique_ptr<PromptStream>> streams;
  for (int i = 0; i < 40; ++i) {
    streams.push_back(std::make_unique<PromptStream>(daemon_, "ipv4:203.0.113.7:1", caller));
    streams.back()->Send(Request(HelloOfClass("invented " + std::to_string(i))));
    EXPECT_TRUE(streams.back()->welcomed());
  }
  EXPECT_TRUE(Play(auth::Role::kIngest, HelloOfClass("laptop"), "192.0.2"));
  EXPECT_EQ(daemon_.store.store.CountScenes("game")->keys, 2u);
}

TEST_F(PlayerNamesTest, ArmsThatTheStudioHasNotMeasuredAreKnownToo) {
  ASSERT_TRUE(Play(auth::Role::kIngest, HelloMessage()));
  EXPECT_EQ(BailOuts("KDTree"), 0u);
  v1::Hello hello = HelloMessage();
  hello.set_active_arm(2);
  EXPECT_TRUE(Play(auth::Role::kPlayer, hello));
  EXPECT_EQ(daemon_.counters.unknown_arm_session_count, 0u);
}

TEST_F(PlayerNamesTest, TheArmsOfARevokedBuildAreUnknown) {
  v1::Hello wrong = HelloWithArm("Wrong");
  wrong.set_build("bad");
  ASSERT_TRUE(Play(auth::Role::kIngest, wrong));
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello()));
  ASSERT_EQ(daemon_.store.store.Revoke({.build = "bad"}, false)->source_count, 1u);
  EXPECT_TRUE(Play(auth::Role::kPlayer, wrong));
  EXPECT_EQ(BailOuts("Wrong"), 0u);
  EXPECT_TRUE(Play(auth::Role::kPlayer, OneArmHello()));
  EXPECT_EQ(BailOuts("Grid"), 2u);
}

TEST_F(PlayerNamesTest, EvidenceThatIsNotStoredIsCountedAndLogged) {
  std::ostringstream text;
  daemon_.log.sinks().push_back(std::make_shared<spdlog::sinks::ostream_sink_mt>(text));
  for (int i = 0; i < 3; ++i) Play(auth::Role::kPlayer, OneArmHello());
  EXPECT_EQ(daemon_.counters.unknown_arm_session_count, 3u);
  EXPECT_THAT(text.str(),
              HasSubstr("about 1 of 1 arms, such as Grid (version 1), of scene harbour of project "
                        "game is not stored"));
  EXPECT_THAT(text.str(), Not(HasSubstr("so far: 2"))) << "once per minute";
}

// Otherwise the session would store its evidence once the store can be read again.
TEST_F(PlayerNamesTest, IfTheStoreDoesNotAnswerAPlayersEvidenceIsNotStored) {
  ASSERT_TRUE(Play(auth::Role::kIngest, OneArmHello()));
  daemon_.store.HoldReads();
  auth::Principal caller;
  caller.role = auth::Role::kPlayer;
  PromptStream stream(daemon_, "ipv4:203.0.113.7:1", caller);
  stream.Send(Request(HelloWithArm("invented")));
  daemon_.Advance(daemon_.options.load_patience_ns);
  EXPECT_TRUE(stream.welcomed());
  stream.Send(BailOut(1, 1));
  stream.Send(Goodbye());
  daemon_.store.EndReads();
  EXPECT_EQ(BailOuts("invented"), 0u);
}

}  // namespace
}  // namespace sweepstake::rpc
