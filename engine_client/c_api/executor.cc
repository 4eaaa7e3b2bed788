#include "engine_client/c_api/executor.h"

#include "engine_client/c_api/sized_struct.h"

namespace sweepstake::c_api {
namespace {

constexpr uint32_t kMaxThreads = 256;

// The function of the parts and its argument, passed through the caller's executor.
struct Job {
  Executor::RunPart run_part;
  void* context;
};

extern "C" {
static void RunPartOfJob(void* job, uint64_t part) {
  const auto& given = *static_cast<const Job*>(job);
  given.run_part(given.context, static_cast<size_t>(part));
}
}

class CallersExecutor final : public Executor {
 public:
  explicit CallersExecutor(const swp_executor& given) : given_(given) {}

  size_t thread_count() const noexcept override { return given_.thread_count; }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    Job job{run_part, context};
    given_.run_parts(given_.user, part_count, RunPartOfJob, &job);
  }

 private:
  const swp_executor given_;
};

constexpr swp_executor kDefaults = {sizeof(swp_executor), 1, nullptr, nullptr};

swp_result CheckExecutor(uint32_t thread_count, const swp_executor& given) {
  if (thread_count > 1) {
    return Fail(SWP_INVALID_ARGUMENT, "thread_count must be 0 or 1 if an executor is given");
  }
  if (given.thread_count < 1 || given.thread_count > kMaxThreads) {
    return Fail(SWP_INVALID_ARGUMENT, "thread_count of swp_executor must be from 1 to 256");
  }
  return given.run_parts == nullptr ? NullArgument("run_parts") : SWP_OK;
}

}  // namespace

swp_result MakeExecutor(uint32_t thread_count, const swp_executor* given,
                        std::unique_ptr<Executor>& executor) {
  if (thread_count > kMaxThreads) {
    return Fail(SWP_INVALID_ARGUMENT, "thread_count must be at most 256");
  }
  if (given != nullptr) {
    swp_executor known = kDefaults;
    swp_result wrong = TakeOptions("swp_executor", given, known);
    if (wrong == SWP_OK) wrong = CheckExecutor(thread_count, known);
    if (wrong == SWP_OK) executor = std::make_unique<CallersExecutor>(known);
    return wrong;
  }
  if (thread_count <= 1) return SWP_OK;
  return CatchFailure(
      [&]() -> swp_result {
        executor = MakeThreadPool(thread_count);
        return SWP_OK;
      },
      [](const char*) {
        return Fail(SWP_RESOURCE_EXHAUSTED,
                    "the system cannot start that many threads: use a lower thread_count");
      });
}

}  // namespace sweepstake::c_api

swp_result swp_executor_init(swp_executor* executor) {
  return sweepstake::c_api::Give("swp_executor", sweepstake::c_api::kDefaults, executor);
}
