// Peers of other libraries against the definition of overlap, as many as are built in.
#include <gtest/gtest.h>

#include <algorithm>

#include "engine_client/cli/game/pair_oracle.h"
#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/peers/peer_registry.h"

namespace sweepstake::cli {
namespace {

// The first frame in which the peer's pairs differ from the right ones; -1 for none.
int FirstWrongFrame(Peer& peer, Scene& scene, int frames) {
  PairOracle oracle;
  PairBuffer pairs;
  for (int frame = 0; frame < frames; ++frame) {
    if (frame == 0) {
      peer.Build(scene.aabbs());
    } else {
      scene.Step();
      peer.Update(scene.aabbs());
    }
    pairs.Clear();
    peer.FindPairs(pairs);
    if (!ComparePairs(pairs.pairs(), oracle.Find(scene.aabbs())).empty()) return frame;
  }
  return -1;
}

TEST(Peers, FindTheRightPairsInEveryShapeOfScene) {
  for (const PeerLibrary& library : PeerLibraries()) {
    for (const PeerKind& kind : library.kinds) {
      for (const char* scene_name :
           {"suite-b", "suite-g", "nearly-resting", "few-moving", "all-coincident",
            "touching-faces", "zero-size", "one-huge", "teleporting", "beams", "clusters", "planar",
            "sizes-1-to-1000", "empty", "one", "two"}) {
        const auto peer = kind.make(kind.name, 1);
        const auto scene = std::move(*OpenScene({scene_name, 200, 3}));
        EXPECT_EQ(FirstWrongFrame(*peer, *scene, 12), -1) << kind.name << " in " << scene_name;
      }
    }
  }
}

TEST(Peers, FollowACountThatGrowsAndShrinks) {
  for (const PeerLibrary& library : PeerLibraries()) {
    for (const PeerKind& kind : library.kinds) {
      const auto peer = kind.make(kind.name, 1);
      const auto scene = std::move(*OpenScene({"spawning", 256, 3}));
      EXPECT_EQ(FirstWrongFrame(*peer, *scene, 80), -1) << kind.name;
    }
  }
}

TEST(Peers, FindTheSamePairsWithThreads) {
  for (const PeerLibrary& library : PeerLibraries()) {
    for (const PeerKind& kind : library.kinds) {
      if (!kind.takes_threads) continue;
      const auto peer = kind.make(kind.name, 3);
      const auto scene = std::move(*OpenScene({"suite-g", 3000, 3}));
      EXPECT_EQ(FirstWrongFrame(*peer, *scene, 10), -1) << kind.name;
    }
  }
}

TEST(Peers, SayWhatBringsThemAndWhichFamilyTheyAreComparedWith) {
  const auto families = BroadPhaseNames();
  for (const PeerLibrary& library : PeerLibraries()) {
    EXPECT_FALSE(library.package.empty()) << library.name;
    EXPECT_EQ(library.version.empty(), library.kinds.empty()) << library.name;
    for (const PeerKind& kind : library.kinds) {
      EXPECT_NE(std::find(families.begin(), families.end(), kind.family), families.end())
          << kind.name;
    }
  }
}

}  // namespace
}  // namespace sweepstake::cli
