// Measures the broad phase of worlds of ODE: each of our arms, and ODE's own spaces, in one run.
//
//   ode_bench [BODIES] [STEPS] [SCENERY]    one line of JSON for each contestant
//
// The bodies fall on a heap between boxes without a body, the scenery. Each contestant plays the
// game in its own world. They take turns by blocks of steps in a rotating order. The time of a step
// is that of dSpaceCollide or OdeBroadPhase::Collide with a callback that only stores the pair. A
// ratio is the median over the steps of a contestant's time ÷ that of dHashSpace, the default
// choice of games. The worlds differ slightly, because the order of contacts differs; our worlds
// and that of dSimpleSpace are equal. dHashSpace misses some pairs.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/programs/median.h"
#include "tests/support/ode/adaptive_ode_game.h"

namespace sweepstake::test_support {
namespace {

constexpr int kBlock = 10;

struct Contestant {
  std::string name;
  std::function<void()> step;
  OdeGame* game;
  std::vector<double> times_ns = {};
  size_t pair_count = 0;  // the sum over all steps
};

template <typename Game>
Contestant Entrant(std::string name, std::shared_ptr<Game> game) {
  return {std::move(name), [game] { game->Step(); }, &game->game()};
}

std::vector<Contestant> Contestants(const OdeGameOptions& options) {
  std::vector<Contestant> all;
  const auto add_own = [&](const char* name, dSpaceID (*make_space)(dSpaceID)) {
    OdeGameOptions own = options;
    own.make_space = make_space;
    all.push_back(Entrant(name, std::make_shared<OwnOdeGame>(own)));
  };
  add_own("dHashSpace", dHashSpaceCreate);
  add_own("dSweepAndPruneSpace",
          [](dSpaceID parent) { return dSweepAndPruneSpaceCreate(parent, dSAP_AXES_XYZ); });
  add_own("dSimpleSpace", dSimpleSpaceCreate);
  for (const std::string_view arm : BroadPhaseNames()) {
    all.push_back(
        Entrant(std::string(arm), std::make_shared<AdaptiveOdeGame>(OneArm(arm), options)));
  }
  return all;
}

void Measure(int bodies, int steps, int scenery) {
  OdeGameOptions options = OdePileOf(bodies);
  options.scenery_count = scenery;
  std::vector<Contestant> contestants = Contestants(options);
  for (int block = 0; block * kBlock < steps; ++block) {
    for (size_t turn = 0; turn < contestants.size(); ++turn) {
      Contestant& next = contestants[(static_cast<size_t>(block) + turn) % contestants.size()];
      for (int step = 0; step < kBlock; ++step) {
        next.step();
        next.times_ns.push_back(static_cast<double>(next.game->collide_ns()));
        next.pair_count += next.game->calls().size();
      }
    }
  }
  for (const Contestant& one : contestants) {
    std::printf(
        "{\"engine\": \"ODE\", \"geoms\": %d, \"steps\": %zu, \"contestant\": \"%s\", "
        "\"ms\": %.4f, \"ratio\": %.3f, \"pairs\": %.0f}\n",
        one.game->geom_count(), one.times_ns.size(), one.name.c_str(), Median(one.times_ns) / 1e6,
        MedianRatio(one.times_ns, contestants.front().times_ns),
        static_cast<double>(one.pair_count) / static_cast<double>(one.times_ns.size()));
  }
}

}  // namespace
}  // namespace sweepstake::test_support

int main(int argc, char** argv) {
  const auto number = [&](int at, int otherwise) {
    return at < argc ? std::max(1, std::atoi(argv[at])) : otherwise;
  };
  sweepstake::test_support::Measure(number(1, 1000), number(2, 300), number(3, 2000));
}
