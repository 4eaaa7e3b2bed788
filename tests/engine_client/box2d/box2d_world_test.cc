// Gives our broad phase the calls that a world of Box2D makes to its own, and compares the fat
// boxes and the contacts in each step.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "sweepstake/box2d.h"
#include "tests/support/box2d/box2d_game.h"
#include "tests/support/one_arm.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::test_support {
namespace {

using Contacts = std::set<std::pair<uintptr_t, uintptr_t>>;

std::pair<uintptr_t, uintptr_t> NumbersOf(b2Fixture* a, b2Fixture* b) {
  return std::minmax(a->GetUserData().pointer, b->GetUserData().pointer);
}

// Makes contacts from the pairs of our broad phase by the rules of b2ContactManager.
class Mirror {
 public:
  explicit Mirror(std::string_view arm)
      : search_(std::move(*AdaptiveBroadPhase::Create(OneArm(arm), nullptr))) {}

  void Step(Box2dGame& game) {
    game.PlayEvents();
    search_->BeginFrame();
    for (b2Fixture* const fixture : game.destroyed()) Destroy(fixture);
    for (const auto& [fixture, box, displacement] : game.created()) {
      ids_[fixture] = broad_phase_.CreateProxy(box, fixture);
    }
    if (!game.created().empty()) broad_phase_.UpdatePairs(this);
    std::erase_if(contacts_, [&](const auto& contact) {
      const auto& [a, b] = contact.second;
      return !broad_phase_.TestOverlap(ids_.at(a), ids_.at(b));
    });
    game.Step();
    for (const auto& [fixture, box, displacement] : game.moved()) {
      broad_phase_.MoveProxy(ids_.at(fixture), box, displacement);
    }
    broad_phase_.UpdatePairs(this);
    search_->EndFrame({});
  }

  void AddPair(void* user_data_a, void* user_data_b) {
    auto* const a = static_cast<b2Fixture*>(user_data_a);
    auto* const b = static_cast<b2Fixture*>(user_data_b);
    const bool is_dynamic =
        a->GetBody()->GetType() == b2_dynamicBody || b->GetBody()->GetType() == b2_dynamicBody;
    if (a->GetBody() == b->GetBody() || !is_dynamic) return;
    if (b2ContactFilter().ShouldCollide(a, b)) contacts_[NumbersOf(a, b)] = {a, b};
  }

  Contacts contacts() const {
    Contacts contacts;
    for (const auto& [numbers, fixtures] : contacts_) contacts.insert(numbers);
    return contacts;
  }

  // Returns the number of proxies of the world whose fat box is another one here.
  int OtherBoxes(const b2World& world) const {
    struct Comparison {
      bool QueryCallback(int32 id) {
        const auto* const proxy = static_cast<b2FixtureProxy*>(theirs->GetUserData(id));
        const b2AABB& our = mirror->broad_phase_.GetFatAABB(mirror->ids_.at(proxy->fixture));
        const b2AABB& their = theirs->GetFatAABB(id);
        if (our.lowerBound != their.lowerBound || our.upperBound != their.upperBound) ++others;
        return true;
      }
      const Mirror* mirror;
      const b2BroadPhase* theirs;
      int others = 0;
    } comparison{this, &world.GetContactManager().m_broadPhase};
    b2AABB all;
    all.lowerBound.Set(-1e6F, -1e6F);
    all.upperBound.Set(1e6F, 1e6F);
    comparison.theirs->Query(&comparison, all);
    return comparison.others;
  }

  int proxy_count() const { return broad_phase_.GetProxyCount(); }

 private:
  void Destroy(b2Fixture* fixture) {
    std::erase_if(contacts_, [&](const auto& contact) {
      return contact.second.first == fixture || contact.second.second == fixture;
    });
    broad_phase_.DestroyProxy(ids_.extract(fixture).mapped());
  }

  std::unique_ptr<AdaptiveBroadPhase> search_;
  Box2dBroadPhase broad_phase_{*search_};
  std::map<b2Fixture*, int32> ids_;
  std::map<std::pair<uintptr_t, uintptr_t>, std::pair<b2Fixture*, b2Fixture*>> contacts_;
};

Contacts ContactsOf(const b2World& world) {
  Contacts contacts;
  for (const b2Contact* contact = world.GetContactList(); contact != nullptr;
       contact = contact->GetNext()) {
    contacts.insert(NumbersOf(const_cast<b2Contact*>(contact)->GetFixtureA(),
                              const_cast<b2Contact*>(contact)->GetFixtureB()));
  }
  return contacts;
}

class Box2dWorldTest : public ::testing::TestWithParam<std::string_view> {};

INSTANTIATE_TEST_SUITE_P(Each, Box2dWorldTest, ::testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(Box2dWorldTest, HasTheContactsOfTheBroadPhaseOfBox2D) {
  Box2dGame game({.pile_count = 100, .visitor_interval = 5, .half_width = 5});
  Mirror mirror(GetParam());
  const auto steps = static_cast<int>(FromEnvironment("TEST_STEPS", 240));
  for (int step = 0; step < steps; ++step) {
    mirror.Step(game);
    ASSERT_EQ(mirror.proxy_count(), game.world().GetProxyCount()) << "step " << step;
    ASSERT_EQ(mirror.OtherBoxes(game.world()), 0) << "step " << step;
    ASSERT_EQ(mirror.contacts(), ContactsOf(game.world())) << "step " << step;
  }
  EXPECT_GT(game.world().GetContactCount(), 100);
}

}  // namespace
}  // namespace sweepstake::test_support
