// A game with a session and its own allocator, which runs out of memory. Without exceptions the
// library then calls the game's hook and ends the program.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#include "sweepstake/adaptive_session.h"
#include "sweepstake/hooks.h"
#include "sweepstake/scene.h"

namespace {

using namespace sweepstake;

bool memory_is_used_up = false;

Hooks GameHooks() {
  Hooks hooks;
  hooks.allocate = [](size_t bytes, size_t alignment, void*) -> void* {
    if (memory_is_used_up) return nullptr;
    return ::operator new (bytes, std::align_val_t{alignment}, std::nothrow);
  };
  hooks.release = [](void* pointer, size_t, size_t alignment, void*) {
    ::operator delete (pointer, std::align_val_t{alignment});
  };
  // This call is what the program tests.
  hooks.out_of_memory = [](void*) { std::_Exit(memory_is_used_up ? 0 : 2); };
  return hooks;
}

bool PlaysWithASession() {
  auto game = AdaptiveSession::Create(MakeEmbeddedSession());
  auto scene = MakeScene("suite-b", {.object_count = 300});
  if (!game.ok() || !scene.ok()) return false;
  bool finds_pairs = true;
  for (int frame = 0; frame < 200; ++frame) {
    game->BeginFrame();
    finds_pairs = finds_pairs && !game->FindPairs((*scene)->aabbs()).empty();
    game->EndFrame({16'000'000, 0});
    (*scene)->Step();
  }
  game->session().Stop();
  return finds_pairs && game->session().stats().sent_frame_count == 200;
}

}  // namespace

int main() {
  if (!SetHooks(GameHooks()).ok() || !PlaysWithASession()) return 1;
  PairBuffer pairs;
  memory_is_used_up = true;
  pairs.Append({0, 1});
  return 3;
}
