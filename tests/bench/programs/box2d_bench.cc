// Measures the broad phase of a world of Box2D: each of our arms, and Box2D's own, in one run.
//
//   box2d_bench [BODIES] [STEPS]    one line of JSON for each contestant
//
// A world plays the game, and every contestant gets the calls that the world makes to its broad
// phase. They take turns in a rotating order. The time of a step is that of all MoveProxy calls and
// of UpdatePairs. `ratio` is the median over the steps of a contestant's time ÷ that of
// b2BroadPhase, `total_ratio` the quotient of the sums. They differ, because b2BroadPhase searches
// only for proxies that have left their fat boxes: many while the heap falls, few at rest.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sweepstake/box2d.h"
#include "tests/bench/programs/median.h"
#include "tests/support/box2d/box2d_game.h"
#include "tests/support/one_arm.h"

namespace sweepstake::test_support {
namespace {

class Contestant {
 public:
  explicit Contestant(std::string name) : name_(std::move(name)) {}
  virtual ~Contestant() = default;

  virtual void Create(const Box2dGame::Call& call) = 0;
  virtual void Step(std::span<const Box2dGame::Call> calls) = 0;
  const std::string& name() const { return name_; }

  std::vector<double> times_ns;
  size_t pair_count = 0;  // the sum over all steps

 private:
  const std::string name_;
};

template <typename BroadPhase>
class Entrant final : public Contestant {
 public:
  Entrant(std::string name, std::unique_ptr<AdaptiveBroadPhase> search,
          std::unique_ptr<BroadPhase> broad_phase)
      : Contestant(std::move(name)),
        search_(std::move(search)),
        broad_phase_(std::move(broad_phase)) {}

  void Create(const Box2dGame::Call& call) override {
    ids_[call.fixture] = broad_phase_->CreateProxy(call.box, call.fixture);
  }

  void Step(std::span<const Box2dGame::Call> calls) override {
    step_ids_.clear();
    for (const auto& call : calls) step_ids_.push_back(ids_.at(call.fixture));
    if (search_ != nullptr) search_->BeginFrame();
    const auto before = std::chrono::steady_clock::now();
    for (size_t i = 0; i < calls.size(); ++i) {
      broad_phase_->MoveProxy(step_ids_[i], calls[i].box, calls[i].displacement);
    }
    broad_phase_->UpdatePairs(this);
    const auto time = std::chrono::steady_clock::now() - before;
    if (search_ != nullptr) search_->EndFrame({.frame_time_ns = 16'666'667});
    times_ns.push_back(static_cast<double>(std::chrono::nanoseconds(time).count()));
  }

  void AddPair(void* /*user_data_a*/, void* /*user_data_b*/) { ++pair_count; }

 private:
  std::unique_ptr<AdaptiveBroadPhase> search_;
  std::unique_ptr<BroadPhase> broad_phase_;
  std::unordered_map<b2Fixture*, int32> ids_;
  std::vector<int32> step_ids_;
};

std::vector<std::unique_ptr<Contestant>> Contestants() {
  std::vector<std::unique_ptr<Contestant>> all;
  all.push_back(std::make_unique<Entrant<b2BroadPhase>>("b2BroadPhase", nullptr,
                                                        std::make_unique<b2BroadPhase>()));
  for (const std::string_view arm : BroadPhaseNames()) {
    auto search = std::move(*AdaptiveBroadPhase::Create(OneArm(arm), nullptr));
    auto broad_phase = std::make_unique<Box2dBroadPhase>(*search);
    all.push_back(std::make_unique<Entrant<Box2dBroadPhase>>(std::string(arm), std::move(search),
                                                             std::move(broad_phase)));
  }
  return all;
}

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

void Measure(int bodies, int steps) {
  Box2dGame game(Box2dPileOf(bodies));
  const auto contestants = Contestants();
  for (const auto& one : contestants) {
    for (const Box2dGame::Call& call : game.created()) one->Create(call);
  }
  for (int step = 0; step < steps; ++step) {
    game.Step();
    for (size_t turn = 0; turn < contestants.size(); ++turn) {
      contestants[(static_cast<size_t>(step) + turn) % contestants.size()]->Step(game.moved());
    }
  }
  for (const auto& one : contestants) {
    std::printf(
        "{\"engine\": \"Box2D\", \"fixtures\": %d, \"steps\": %zu, \"contestant\": \"%s\", "
        "\"ms\": %.4f, \"ratio\": %.3f, \"total_ratio\": %.3f, \"new_pairs\": %.0f}\n",
        game.world().GetProxyCount(), one->times_ns.size(), one->name().c_str(),
        Median(one->times_ns) / 1e6, MedianRatio(one->times_ns, contestants.front()->times_ns),
        Sum(one->times_ns) / Sum(contestants.front()->times_ns),
        static_cast<double>(one->pair_count) / static_cast<double>(one->times_ns.size()));
  }
}

}  // namespace
}  // namespace sweepstake::test_support

int main(int argc, char** argv) {
  const auto number = [&](int at, int otherwise) {
    return at < argc ? std::max(1, std::atoi(argv[at])) : otherwise;
  };
  sweepstake::test_support::Measure(number(1, 5000), number(2, 600));
}
