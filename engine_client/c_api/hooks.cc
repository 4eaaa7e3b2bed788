// Converts the C hooks, whose sizes are uint64_t, to the hooks of hooks.h.
#include "sweepstake/hooks.h"

#include "engine_client/c_api/boundary.h"
#include "engine_client/c_api/sized_struct.h"

namespace {

using sweepstake::Hooks;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

constexpr swp_hooks kNoHooks = {sizeof(swp_hooks), 0,       nullptr, nullptr, nullptr,
                                nullptr,           nullptr, nullptr, nullptr};

// One slot has the hooks in use, the other receives new ones. If SetHooks rejects the new ones, the
// slot in use stays the same.
constinit swp_hooks given_hooks[2] = {kNoHooks, kNoHooks};
constinit size_t present_slot = 0;

const swp_hooks& Given(void* user) { return *static_cast<const swp_hooks*>(user); }

void* Allocate(size_t bytes, size_t alignment, void* user) {
  return Given(user).allocate(bytes, alignment, Given(user).user);
}
void Release(void* pointer, size_t bytes, size_t alignment, void* user) {
  Given(user).release(pointer, bytes, alignment, Given(user).user);
}
void BeginZone(const char* name, void* user) { Given(user).zone_begin(name, Given(user).user); }
void EndZone(const char* name, void* user) { Given(user).zone_end(name, Given(user).user); }
void StartThread(const char* name, void* user) {
  Given(user).thread_started(name, Given(user).user);
}
void ReportOutOfMemory(void* user) { Given(user).out_of_memory(Given(user).user); }

// Returns `function` if the game has set the hook `given`, otherwise null.
template <typename Function, typename GivenFunction>
Function* IfGiven(GivenFunction* given, Function* function) {
  return given == nullptr ? nullptr : function;
}

swp_result InstallHooks(const swp_hooks& known) {
  swp_hooks& next = given_hooks[1 - present_slot];
  next = known;
  const sweepstake::Status status =
      sweepstake::SetHooks({.user = &next,
                            .allocate = IfGiven(next.allocate, Allocate),
                            .release = IfGiven(next.release, Release),
                            .zone_begin = IfGiven(next.zone_begin, BeginZone),
                            .zone_end = IfGiven(next.zone_end, EndZone),
                            .thread_started = IfGiven(next.thread_started, StartThread),
                            .out_of_memory = IfGiven(next.out_of_memory, ReportOutOfMemory)});
  if (status.ok()) present_slot = 1 - present_slot;
  return ToResult(status);
}

}  // namespace

swp_result swp_hooks_init(swp_hooks* hooks) {
  return Guard([&] { return Give("swp_hooks", kNoHooks, hooks); });
}

swp_result swp_set_hooks(const swp_hooks* hooks) {
  return Guard([&] {
    swp_hooks known = kNoHooks;
    const swp_result wrong = TakeOptions("swp_hooks", hooks, known);
    if (wrong != SWP_OK) return wrong;
    if (known.reserved != 0) return Fail(SWP_INVALID_ARGUMENT, "reserved must be 0");
    if (swp_live_count(SWP_KIND_ANY) > 0) {  // their threads read the hooks
      return Fail(SWP_FAILED_PRECONDITION,
                  "objects exist: set the hooks before you create the first one or after you "
                  "destroy the last one");
    }
    return InstallHooks(known);
  });
}
