// A C++ game with a ball that touches a floor: the example of engine_client/README.md.
#include "sweepstake/proxy_set.h"

#include <vector>

#include "sweepstake/adaptive_broad_phase.h"

namespace {

using namespace sweepstake;

std::vector<ProxyPair> began;
std::vector<ProxyPair> ended;
std::vector<ProxyPair> touched;

void Touch(ProxyHandle a, ProxyHandle b) { touched.push_back({a, b}); }
void Begin(ProxyHandle a, ProxyHandle b) { began.push_back({a, b}); }
void End(ProxyHandle a, ProxyHandle b) { ended.push_back({a, b}); }

constexpr Aabb ball_box = {{0, 0, 5}, {1, 1, 6}};
constexpr Aabb floor_box = {{-9, -9, -1}, {9, 9, 0}};

}  // namespace

int main() {
  auto made = AdaptiveBroadPhase::Create({}, nullptr);
  if (!made.ok()) return 1;
  AdaptiveBroadPhase* const adaptive = made->get();

  ProxySet proxies({.pair_events = true});
  const ProxyHandle ball = proxies.Add(ball_box, {.filter = {.category = 2, .mask = 1}});
  const ProxyHandle floor = proxies.Add(floor_box, {.is_static = true});
  bool right = true;
  for (const float height : {5.0F, 0.0F, 0.0F, 5.0F}) {
    const Aabb moved_box = {{0, 0, height}, {1, 1, height + 1}};
    began.clear();
    ended.clear();
    touched.clear();
    adaptive->BeginFrame();
    proxies.Move(ball, moved_box);
    for (const OverlapPair& pair : adaptive->FindPairs(proxies)) {
      Touch(proxies.handle(pair.a), proxies.handle(pair.b));
    }
    for (const ProxyPair& pair : proxies.added()) Begin(pair.a, pair.b);
    for (const ProxyPair& pair : proxies.removed()) End(pair.a, pair.b);
    RayHit hit;
    const Status cast = proxies.CastRayNearest({{0, 0, 9}, {0, 0, -1}}, {}, hit);
    adaptive->EndFrame({16'000'000, 0});
    const bool lies = height == 0;
    right = right && touched.size() == (lies ? 1U : 0U) && cast.ok() && hit.proxy == ball &&
            hit.distance == 8 - height;
    if (lies) right = right && touched[0] == ProxyPair{ball, floor};
  }
  return right && began.empty() && ended.size() == 1 && ended[0] == ProxyPair{ball, floor} ? 0 : 1;
}
