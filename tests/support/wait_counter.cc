#include "tests/support/wait_counter.h"

#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>
#include <ctime>

#include <cstdarg>
#include <cstdlib>

#include "tests/support/sanitizers/active.h"

namespace {

thread_local constinit bool counting = false;
thread_local constinit uint64_t call_count = 0;
thread_local constinit const char* latest_call = "";

[[maybe_unused]] void Count(const char* name) {
  if (!counting) return;
  ++call_count;
  latest_call = name;
}

// Returns the intercepted function. It is looked up at each call: a static variable would need a
// guard, which may lock.
template <typename Function>
[[maybe_unused]] Function* Next(const char* name) {
  void* next = dlsym(RTLD_NEXT, name);
  if (next == nullptr) std::abort();
  return reinterpret_cast<Function*>(next);
}

}  // namespace

namespace sweepstake::test_support {

WaitCounter::WaitCounter() {
  call_count = 0;
  latest_call = "";
  counting = true;
}
WaitCounter::~WaitCounter() { counting = false; }
bool WaitCounter::Works() { return SWEEPSTAKE_TSAN == 0; }
uint64_t WaitCounter::count() const { return call_count; }
const char* WaitCounter::last_call() const { return latest_call; }

}  // namespace sweepstake::test_support

// ThreadSanitizer intercepts the same functions and needs their real caller.
#if !SWEEPSTAKE_TSAN

// Each definition replaces the C library's function in the whole program. The macros' arguments are
// types, names and lists with their own parentheses.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define SWEEPSTAKE_INTERPOSE(result, name, parameters, arguments)            \
  extern "C" __attribute__((visibility("default"))) result name parameters { \
    Count(#name);                                                            \
    return Next<result parameters>(#name) arguments;                         \
  }
// NOLINTEND(bugprone-macro-parentheses)

SWEEPSTAKE_INTERPOSE(int, pthread_mutex_lock, (pthread_mutex_t * m), (m))
SWEEPSTAKE_INTERPOSE(int, pthread_mutex_trylock, (pthread_mutex_t * m), (m))
SWEEPSTAKE_INTERPOSE(int, pthread_mutex_timedlock, (pthread_mutex_t * m, const timespec* t), (m, t))
SWEEPSTAKE_INTERPOSE(int, pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
SWEEPSTAKE_INTERPOSE(int, pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
SWEEPSTAKE_INTERPOSE(int, pthread_spin_lock, (pthread_spinlock_t * l), (l))
SWEEPSTAKE_INTERPOSE(int, pthread_barrier_wait, (pthread_barrier_t * b), (b))
SWEEPSTAKE_INTERPOSE(int, pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
SWEEPSTAKE_INTERPOSE(int, pthread_cond_timedwait,
                     (pthread_cond_t * c, pthread_mutex_t* m, const timespec* t), (c, m, t))
SWEEPSTAKE_INTERPOSE(int, pthread_cond_clockwait,
                     (pthread_cond_t * c, pthread_mutex_t* m, clockid_t k, const timespec* t),
                     (c, m, k, t))
SWEEPSTAKE_INTERPOSE(int, pthread_cond_signal, (pthread_cond_t * c), (c))
SWEEPSTAKE_INTERPOSE(int, pthread_cond_broadcast, (pthread_cond_t * c), (c))
SWEEPSTAKE_INTERPOSE(int, pthread_join, (pthread_t t, void** r), (t, r))
SWEEPSTAKE_INTERPOSE(int, sem_wait, (sem_t * s), (s))
SWEEPSTAKE_INTERPOSE(int, sem_timedwait, (sem_t * s, const timespec* t), (s, t))
SWEEPSTAKE_INTERPOSE(int, sem_post, (sem_t * s), (s))
SWEEPSTAKE_INTERPOSE(int, nanosleep, (const timespec* t, timespec* r), (t, r))
SWEEPSTAKE_INTERPOSE(int, clock_nanosleep, (clockid_t k, int f, const timespec* t, timespec* r),
                     (k, f, t, r))
SWEEPSTAKE_INTERPOSE(int, usleep, (useconds_t t), (t))
SWEEPSTAKE_INTERPOSE(int, sched_yield, (), ())
SWEEPSTAKE_INTERPOSE(ssize_t, read, (int f, void* b, size_t n), (f, b, n))
SWEEPSTAKE_INTERPOSE(ssize_t, write, (int f, const void* b, size_t n), (f, b, n))
SWEEPSTAKE_INTERPOSE(ssize_t, send, (int f, const void* b, size_t n, int o), (f, b, n, o))
SWEEPSTAKE_INTERPOSE(ssize_t, sendmsg, (int f, const msghdr* m, int o), (f, m, o))
SWEEPSTAKE_INTERPOSE(ssize_t, recv, (int f, void* b, size_t n, int o), (f, b, n, o))
SWEEPSTAKE_INTERPOSE(ssize_t, recvmsg, (int f, msghdr* m, int o), (f, m, o))
SWEEPSTAKE_INTERPOSE(int, poll, (pollfd * f, nfds_t n, int t), (f, n, t))
SWEEPSTAKE_INTERPOSE(int, epoll_wait, (int f, epoll_event* e, int n, int t), (f, e, n, t))

// libstdc++ implements std::atomic::wait and notify by syscall(SYS_futex, …) with up to six
// arguments. Like the C library's function, this one reads all six, even if the caller passed
// fewer.
extern "C" __attribute__((visibility("default"), no_sanitize("address"))) long syscall(
    long number, ...) noexcept {
  Count("syscall");
  va_list list;
  va_start(list, number);
  long argument[6];
  for (long& value : argument) value = va_arg(list, long);
  va_end(list);
  return Next<long(long, ...)>("syscall")(number, argument[0], argument[1], argument[2],
                                          argument[3], argument[4], argument[5]);
}

#endif
