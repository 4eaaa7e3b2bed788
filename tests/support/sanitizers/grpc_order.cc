// Informs ThreadSanitizer of the order that gRPC guarantees. ThreadSanitizer cannot see it, because
// the libraries of gRPC and Abseil are built without it. An operation starts before its callback
// runs. Data written before StartRead, StartWrite or Finish are therefore visible in OnReadDone,
// OnWriteDone and OnDone. A server starts before a call of it begins. Nothing else is ordered:
// accesses that our own locks must guard are still checked.
//
// This file replaces functions of the C library underneath gRPC's headers, in programs that have it
// among their sources: functions that start a server or a batch of operations, the function that
// keeps a new call, and functions that release the call just before the callback.
#include <dlfcn.h>
#include <grpc/grpc.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>

extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);

namespace {

template <typename Function>
Function* Next(const char* name) {
  void* next = dlsym(RTLD_NEXT, name);
  if (next == nullptr) std::abort();
  return reinterpret_cast<Function*>(next);
}

}  // namespace

namespace {

char server_start;  // its address stands for the start of any server

}  // namespace

// gRPC closes its end of a pair of sockets, which ThreadSanitizer does not see. It would report
// that the next owner of the descriptor's number races with the creation of the pair, so the
// creation is hidden too.
extern "C" __attribute__((visibility("default"))) int socketpair(int domain, int type, int protocol,
                                                                 int ends[2]) noexcept {
  return static_cast<int>(syscall(SYS_socketpair, domain, type, protocol, ends));
}

extern "C" __attribute__((visibility("default"))) void grpc_server_start(grpc_server* server) {
  static auto* const next = Next<decltype(grpc_server_start)>("grpc_server_start");
  __tsan_release(&server_start);
  next(server);
}

extern "C" __attribute__((visibility("default"))) void grpc_call_ref(grpc_call* call) {
  static auto* const next = Next<decltype(grpc_call_ref)>("grpc_call_ref");
  __tsan_acquire(&server_start);
  next(call);
}

extern "C" __attribute__((visibility("default"))) grpc_call_error grpc_call_start_batch(
    grpc_call* call, const grpc_op* ops, size_t count, void* tag, void* reserved) {
  static auto* const next = Next<decltype(grpc_call_start_batch)>("grpc_call_start_batch");
  __tsan_release(call);
  return next(call, ops, count, tag, reserved);
}

extern "C" __attribute__((visibility("default"))) void grpc_call_unref(grpc_call* call) {
  static auto* const next = Next<decltype(grpc_call_unref)>("grpc_call_unref");
  __tsan_acquire(call);
  next(call);
}
