// The state of a thread: its floating-point environment, its name in debuggers and profilers, its
// priority and its CPU time. The id and the CPU time of the process are here too.
#include "engine_client/broad_phase/host/float_environment.h"
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
#include <time.h>
#endif
#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif
#if defined(__linux__)
#include <sys/resource.h>
#elif defined(__APPLE__)
#include <pthread/qos.h>
#endif

namespace sweepstake {
namespace {

#if defined(_WIN32)

// SetThreadDescription exists since Windows 10. On earlier systems threads stay unnamed.
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

void LowerThisThreadsPriority() noexcept {
  SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_LOWEST);
}

uint64_t TimeNs(const FILETIME& time) noexcept {
  return (uint64_t{time.dwHighDateTime} << 32 | time.dwLowDateTime) * 100;
}

// Returns at least 1, because 0 means that the time is unknown. A thread has no tick at first.
uint64_t CpuNs(const FILETIME& kernel, const FILETIME& user) noexcept {
  const uint64_t time_ns = TimeNs(kernel) + TimeNs(user);
  return time_ns > 0 ? time_ns : 1;
}

#elif defined(__APPLE__)

void NameThisThread(const char* name) noexcept { pthread_setname_np(name); }

void LowerThisThreadsPriority() noexcept { pthread_set_qos_class_self_np(QOS_CLASS_UTILITY, 0); }

#elif defined(__linux__)

void NameThisThread(const char* name) noexcept { pthread_setname_np(pthread_self(), name); }

// Ten steps of niceness reduce the thread's weight to a tenth of another thread's weight on the
// same core. With a lower weight, a caller that waits for the thread's end would wait too long on a
// machine without an idle core.
void LowerThisThreadsPriority() noexcept {
  constexpr int kSteps = 10;
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kSteps);  // 0: the calling thread
}

#else

void NameThisThread(const char* /*name*/) noexcept {}
void LowerThisThreadsPriority() noexcept {}

#endif

#if defined(__linux__) || defined(__APPLE__)

uint64_t TimeNs(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<uint64_t>(time.tv_sec) * 1'000'000'000 + static_cast<uint64_t>(time.tv_nsec);
}

#endif

}  // namespace

uint64_t ProcessId() noexcept {
#if defined(_WIN32)
  return GetCurrentProcessId();
#elif defined(__unix__) || defined(__APPLE__)
  return static_cast<uint64_t>(getpid());
#else
  return 0;
#endif
}

#if defined(__linux__) || defined(__APPLE__)

uint64_t ThreadCpuNs() noexcept { return TimeNs(CLOCK_THREAD_CPUTIME_ID); }
uint64_t ProcessCpuNs() noexcept { return TimeNs(CLOCK_PROCESS_CPUTIME_ID); }
uint64_t ThreadTimeNs() noexcept { return ThreadCpuNs(); }

#elif defined(_WIN32)

uint64_t ThreadCpuNs() noexcept {
  FILETIME created, exited, kernel, user;
  if (GetThreadTimes(GetCurrentThread(), &created, &exited, &kernel, &user) == 0) return 0;
  return CpuNs(kernel, user);
}

uint64_t ProcessCpuNs() noexcept {
  FILETIME created, exited, kernel, user;
  if (GetProcessTimes(GetCurrentProcess(), &created, &exited, &kernel, &user) == 0) return 0;
  return CpuNs(kernel, user);
}

uint64_t ThreadTimeNs() noexcept { return 0; }

#else

uint64_t ThreadCpuNs() noexcept { return 0; }
uint64_t ProcessCpuNs() noexcept { return 0; }
uint64_t ThreadTimeNs() noexcept { return 0; }

#endif

void NoteThreadStarted(const char* name, ThreadPriority priority) noexcept {
  // On Linux a thread starts in the environment of the thread that has made it.
  SetDefaultFloatEnvironment();
  NameThisThread(name);
  if (priority == ThreadPriority::kLow) LowerThisThreadsPriority();
  const Hooks* const hooks = installed_hooks.load(std::memory_order_relaxed);
  if (hooks != nullptr && hooks->thread_started != nullptr) {
    hooks->thread_started(name, hooks->user);
  }
}

}  // namespace sweepstake
