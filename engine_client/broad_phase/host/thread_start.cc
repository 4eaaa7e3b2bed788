// The begin of a thread: its name in debuggers and profilers, by the system's own call.
#include "engine_client/broad_phase/host/hook_points.h"

#if defined(_WIN32)
#ifndef NOMINMAX
#define NOMINMAX
#endif
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>
#elif defined(__linux__) || defined(__APPLE__)
#include <pthread.h>
#endif

namespace sweepstake {
namespace {

#if defined(_WIN32)

// SetThreadDescription came with Windows 10: earlier systems have no names.
void NameThisThread(const char* name) noexcept {
  using SetDescription = HRESULT(WINAPI*)(HANDLE, PCWSTR);
  const HMODULE kernel = GetModuleHandleW(L"kernel32.dll");
  if (kernel == nullptr) return;
  const auto set_description = reinterpret_cast<SetDescription>(
      reinterpret_cast<void*>(GetProcAddress(kernel, "SetThreadDescription")));
  if (set_description == nullptr) return;
  wchar_t wide[16] = {};
  for (size_t k = 0; k < 15 && name[k] != 0; ++k) wide[k] = static_cast<wchar_t>(name[k]);
  set_description(GetCurrentThread(), wide);
}

#elif defined(__APPLE__)

void NameThisThread(const char* name) noexcept { pthread_setname_np(name); }

#elif defined(__linux__)

void NameThisThread(const char* name) noexcept { pthread_setname_np(pthread_self(), name); }

#else

void NameThisThread(const char* /*name*/) noexcept {}

#endif

}  // namespace

void NoteThreadStarted(const char* name) noexcept {
  NameThisThread(name);
  const Hooks* const hooks = installed_hooks.load(std::memory_order_relaxed);
  if (hooks != nullptr && hooks->thread_started != nullptr) {
    hooks->thread_started(name, hooks->user);
  }
}

}  // namespace sweepstake
