// Measures a broad phase in worlds of Bullet, per step and alone: each of our arms, all arms with
// AI Decides in the process, and Bullet's own broad phases, in one run.
//
//   bullet_bench [WORLD,…] [BODIES] [STEPS]               one line of JSON for each contestant
//   bullet_bench --record FILE.aabbs WORLD [BODIES] [STEPS]  the world's boxes as a scene
//
// The contestants play the same game, each in its own world, and take turns by blocks of steps in a
// rotating order. "Alone" is the time to update the boxes and the pair cache. It includes the time
// in which shapes compute their boxes, which is the same for all. A ratio is the median over the
// steps of a contestant's time ÷ that of btDbvtBroadphase, the default choice of games. Bullet's
// broad phases keep more pairs, which costs time in the rest of the step; the worlds are equal
// until such pairs make bodies fall asleep at other moments. btAxisSweep3 supports at most 32,000
// bodies.
#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sweepstake/scene.h"
#include "sweepstake/session.h"
#include "tests/bench/programs/median.h"
#include "tests/support/bullet/adaptive_bullet_game.h"

namespace sweepstake::test_support {
namespace {

constexpr int kBlock = 10;

struct NamedWorld {
  std::string_view name;
  BulletGameOptions (*make)(int bodies);
};

BulletGameOptions Stacks(int bodies) { return {.stack_height = bodies}; }

BulletGameOptions Chains(int bodies) {
  BulletGameOptions options = PileOf(bodies);
  options.pile_count = 0;
  options.chain_count = bodies / 8;
  return options;
}

BulletGameOptions Visitors(int bodies) {
  BulletGameOptions options = PileOf(bodies);
  options.pile_count = bodies / 2;
  options.visitor_interval = 1;
  options.visitor_limit = bodies / 2;
  return options;
}

// Returns options for every kind of body, for rays and box queries, and for blows that wake the
// heap every five seconds.
BulletGameOptions Mixed(int bodies) {
  BulletGameOptions options = PileOf(bodies);
  options.stack_height = 10;
  options.pile_count = bodies / 2;
  options.chain_count = bodies / 32;
  options.lift_count = 5;
  options.visitor_interval = 5;
  options.visitor_limit = bodies / 4;
  options.blow_interval = 300;
  options.query_interval = 1;
  return options;
}

constexpr NamedWorld kWorlds[] = {{"stack", Stacks},
                                  {"pile", PileOf},
                                  {"chains", Chains},
                                  {"visitors", Visitors},
                                  {"mixed", Mixed}};

// A contestant plays the game and records the time of each step.
class Contestant {
 public:
  Contestant(std::string name, const BulletGameOptions&) : name_(std::move(name)) {}
  virtual ~Contestant() = default;

  void Step() {
    const uint64_t alone_before = game().world().broad_phase_ns();
    const uint64_t before = SteadyClock().NowNs();
    Frame();
    steps_ns.push_back(static_cast<double>(SteadyClock().NowNs() - before));
    alone_ns.push_back(static_cast<double>(game().world().broad_phase_ns() - alone_before));
    pair_count += game().world().getPairCache()->getNumOverlappingPairs();
  }

  virtual BulletGame& game() = 0;
  // Returns the number of arm changes and the last arm.
  virtual std::string Choice() { return {}; }
  const std::string& name() const { return name_; }

  std::vector<double> steps_ns;
  std::vector<double> alone_ns;
  int64_t pair_count = 0;  // the sum over all steps

 private:
  virtual void Frame() = 0;

  const std::string name_;
};

template <typename BroadPhaseOfBullet>
class BulletsOwn final : public Contestant {
 public:
  template <typename... Arguments>
  BulletsOwn(std::string name, const BulletGameOptions& options, Arguments... arguments)
      : Contestant(std::move(name), options),
        broad_phase_(arguments...),
        game_(broad_phase_, options) {}

  BulletGame& game() override { return game_; }

 private:
  void Frame() override { game_.Step(); }

  BroadPhaseOfBullet broad_phase_;
  BulletGame game_;
};

class OneOfOurs final : public Contestant {
 public:
  OneOfOurs(std::string_view arm, const BulletGameOptions& options)
      : Contestant(std::string(arm), options), played_(OneArm(arm), options) {}

  BulletGame& game() override { return played_.game(); }

 private:
  void Frame() override { played_.Step(); }

  AdaptiveBulletGame played_;
};

std::unique_ptr<Session> MakeSession() {
  EmbeddedOptions options;
  options.time_scale = 20;
  return std::move(*MakeEmbeddedSession(options, {}));
}

// Uses AI Decides in the process with time scale 20, because a run lasts only seconds.
class AllOfOurs final : public Contestant {
 public:
  AllOfOurs(std::string name, const BulletGameOptions& options)
      : Contestant(std::move(name), options),
        session_(MakeSession()),
        played_({}, options, &session_->sink()) {
    if (!session_->Start(played_.search()).ok()) std::abort();
  }
  ~AllOfOurs() override { session_->Stop(); }

  BulletGame& game() override { return played_.game(); }
  std::string Choice() override {
    AdaptiveBroadPhase& search = played_.search();
    return std::to_string(search.switch_epoch()) + " switches, at last " +
           search.arms()[search.active_arm()];
  }

 private:
  void Frame() override {
    const uint64_t before = SteadyClock().NowNs();
    played_.search().BeginFrame();
    played_.game().Step();
    played_.search().EndFrame({.frame_time_ns = SteadyClock().NowNs() - before});
  }

  std::unique_ptr<Session> session_;
  AdaptiveBulletGame played_;
};

std::vector<std::unique_ptr<Contestant>> Contestants(const BulletGameOptions& options) {
  constexpr unsigned short kMaxBodies = 32'000;
  const btVector3 corner(options.half_width + 10, 1000, options.half_width + 10);
  std::vector<std::unique_ptr<Contestant>> all;
  all.push_back(std::make_unique<BulletsOwn<btDbvtBroadphase>>("btDbvtBroadphase", options));
  all.push_back(std::make_unique<BulletsOwn<btAxisSweep3>>("btAxisSweep3", options, -corner, corner,
                                                           kMaxBodies));
  all.push_back(std::make_unique<AllOfOurs>("AI Decides", options));
  for (const std::string_view arm : BroadPhaseNames()) {
    all.push_back(std::make_unique<OneOfOurs>(arm, options));
  }
  return all;
}

void Print(const NamedWorld& world, Contestant& one, const Contestant& tree) {
  std::printf(
      "{\"world\": \"%s\", \"bodies\": %d, \"steps\": %zu, \"contestant\": \"%s\", "
      "\"step_ms\": %.4f, \"alone_ms\": %.4f, \"step_ratio\": %.3f, \"alone_ratio\": %.3f, "
      "\"pairs\": %.0f, \"sleeping_at_last\": %d, \"choice\": \"%s\"}\n",
      world.name.data(), one.game().world().getNumCollisionObjects(), one.steps_ns.size(),
      one.name().c_str(), Median(one.steps_ns) / 1e6, Median(one.alone_ns) / 1e6,
      MedianRatio(one.steps_ns, tree.steps_ns), MedianRatio(one.alone_ns, tree.alone_ns),
      static_cast<double>(one.pair_count) / static_cast<double>(one.steps_ns.size()),
      one.game().sleeping_count(), one.Choice().c_str());
  std::fflush(stdout);
}

void Measure(const NamedWorld& world, int bodies, int steps) {
  const auto contestants = Contestants(world.make(bodies));
  for (int block = 0; block * kBlock < steps; ++block) {
    for (size_t turn = 0; turn < contestants.size(); ++turn) {
      Contestant& next = *contestants[(static_cast<size_t>(block) + turn) % contestants.size()];
      for (int step = 0; step < kBlock; ++step) next.Step();
    }
  }
  for (const auto& one : contestants) Print(world, *one, *contestants.front());
}

// The boxes of a world, including the ground and walls, in the order of the world. If a body is
// removed, the last body takes its place in this order.
class WorldScene final : public Scene {
 public:
  WorldScene(const NamedWorld& world, const BulletGameOptions& options)
      : name_(world.name), half_width_(options.half_width), game_(broad_phase_, options) {}

  std::string_view name() const override { return name_; }
  Aabb world() const override {
    return {{-half_width_, 0, -half_width_}, {half_width_, 2 * half_width_, half_width_}};
  }
  uint64_t frame_index() const override { return static_cast<uint64_t>(game_.step_count()); }
  std::span<const Aabb> aabbs() const override { return boxes_; }
  void DoStep() override {
    game_.Step();
    boxes_ = game_.boxes();
  }

 private:
  std::string_view name_;
  float half_width_;
  btDbvtBroadphase broad_phase_;
  BulletGame game_;
  std::span<const Aabb> boxes_ = game_.boxes();
};

int Record(const std::string& file, const NamedWorld& world, int bodies, int steps) {
  WorldScene scene(world, world.make(bodies));
  const Status status = RecordScene(scene, static_cast<uint64_t>(steps), file);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.message().c_str());
  return status.ok() ? 0 : 1;
}

const NamedWorld& WorldOf(const std::string& name) {
  for (const NamedWorld& world : kWorlds) {
    if (world.name == name) return world;
  }
  std::fprintf(stderr, "unknown world '%s'; valid: stack, pile, chains, visitors, mixed\n",
               name.c_str());
  std::exit(2);
}

int Main(std::vector<std::string> arguments) {
  std::string file;
  if (arguments.size() >= 3 && arguments[0] == "--record") {
    file = arguments[1];
    arguments.erase(arguments.begin(), arguments.begin() + 2);
  }
  const auto number = [&](size_t at, int otherwise) {
    return at < arguments.size() ? std::max(1, std::atoi(arguments[at].c_str())) : otherwise;
  };
  const int bodies = number(1, 5000);
  const int steps = number(2, 600);
  if (!file.empty()) return Record(file, WorldOf(arguments[0]), bodies, steps);
  std::stringstream names(arguments.empty() ? "pile,chains,visitors,mixed" : arguments[0]);
  for (std::string name; std::getline(names, name, ',');) Measure(WorldOf(name), bodies, steps);
  return 0;
}

}  // namespace
}  // namespace sweepstake::test_support

int main(int argc, char** argv) { return sweepstake::test_support::Main({argv + 1, argv + argc}); }
