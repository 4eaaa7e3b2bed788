// Compares the pairs of all peers that are built in with the definition of overlap.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "engine_client/cli/game/scene_choice.h"
#include "tests/laboratory/game/pair_oracle.h"
#include "tests/laboratory/peers/peer.h"

namespace sweepstake::cli {
namespace {

// Returns the first frame in which the peer's pairs are wrong, or -1.
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

TEST(Peers, EachHasANameOfItsOwnThatNoBackendHas) {
  const auto backends = BroadPhaseNames();
  std::set<std::string_view> names(backends.begin(), backends.end());
  for (const PeerLibrary& library : PeerLibraries()) {
    for (const PeerKind& kind : library.kinds) {
      EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
      EXPECT_EQ(kind.make(kind.name, 1)->name(), kind.name);
      EXPECT_GT(kind.max_object_count, 0U) << kind.name;
    }
  }
}

TEST(Peers, KeepTheOrderOfTheLibrariesWhateverIsBuiltIn) {
  std::vector<std::string_view> names;
  for (const PeerLibrary& library : PeerLibraries()) names.push_back(library.name);
  EXPECT_EQ(names, (std::vector<std::string_view>{"Bullet", "FCL", "ODE", "Embree",
                                                  "Boost.Geometry", "CGAL"}));
}

TEST(Peers, StartAnewAfterASecondBuild) {
  for (const PeerLibrary& library : PeerLibraries()) {
    for (const PeerKind& kind : library.kinds) {
      const auto peer = kind.make(kind.name, 1);
      const auto crowd = std::move(*OpenScene({"all-coincident", 40, 1}));
      const auto scene = std::move(*OpenScene({"suite-g", 300, 3}));
      EXPECT_EQ(FirstWrongFrame(*peer, *crowd, 2), -1) << kind.name;
      EXPECT_EQ(FirstWrongFrame(*peer, *scene, 5), -1) << kind.name;
    }
  }
}

TEST(RoomyBounds, AreLargerByAQuarterOfTheEdgeOnEachSide) {
  const Aabb boxes[] = {{{0, 0, 0}, {4, 1, 1}}, {{2, -1, 0}, {8, 3, 1}}};
  const Aabb bounds = RoomyBounds(boxes);
  EXPECT_EQ(bounds, (Aabb{{-2, -2, -0.25F}, {10, 4, 1.25F}}));
  EXPECT_EQ(RoomyBounds({}), (Aabb{{0, 0, 0}, {1, 1, 1}}));
}

TEST(Meet, CountsTouchingFacesOnEveryAxis) {
  const Aabb box{{0, 0, 0}, {1, 1, 1}};
  for (int axis = 0; axis < 3; ++axis) {
    Aabb beside = box;
    beside.min[axis] = 1;
    beside.max[axis] = 2;
    EXPECT_TRUE(ValidBoxesOverlap(box, beside)) << axis;
    EXPECT_TRUE(ValidBoxesOverlap(beside, box)) << axis;
    beside.min[axis] = 1.001F;
    EXPECT_FALSE(ValidBoxesOverlap(box, beside)) << axis;
    EXPECT_FALSE(ValidBoxesOverlap(beside, box)) << axis;
  }
}

TEST(AppendPair, SetsTheSmallerIdFirst) {
  PairBuffer pairs;
  AppendPair(pairs, 7, 2);
  AppendPair(pairs, 3, 5);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs.pairs()[0], (OverlapPair{2, 7}));
  EXPECT_EQ(pairs.pairs()[1], (OverlapPair{3, 5}));
}

}  // namespace
}  // namespace sweepstake::cli
