#include "server/rpc/health_service.h"

#include <optional>
#include <string_view>
#include <utility>

namespace sweepstake::rpc {
namespace {

constexpr std::string_view kCheck = "/grpc.health.v1.Health/Check";
constexpr std::string_view kWatch = "/grpc.health.v1.Health/Watch";

// The values of HealthCheckResponse.ServingStatus.
enum class ServingStatus : char { kServing = 1, kNotServing = 2, kServiceUnknown = 3 };

ServingStatus StatusOf(bool is_serving) {
  return is_serving ? ServingStatus::kServing : ServingStatus::kNotServing;
}

// Returns a HealthCheckResponse. Its only field, 1, is the status.
grpc::ByteBuffer ResponseOf(ServingStatus health) {
  const char bytes[] = {'\x08', static_cast<char>(health)};
  const grpc::Slice slice(bytes, sizeof bytes);
  return {&slice, 1};
}

}  // namespace

// Reads the request. A HealthCheckRequest without bytes has the empty service name.
class HealthService::Call : public grpc::ServerGenericBidiReactor {
 public:
  Call() { StartRead(&request_); }
  void OnReadDone(bool ok) override {
    if (!ok) return End({grpc::StatusCode::INVALID_ARGUMENT, "the request is missing"});
    OnRequest(/*is_known=*/request_.Length() == 0);
  }

 protected:
  virtual void OnRequest(bool is_known) = 0;
  // Finishes the call, unless it was finished.
  virtual void End(grpc::Status status) { Finish(std::move(status)); }

 private:
  grpc::ByteBuffer request_;
};

class HealthService::CheckCall final : public Call {
 public:
  explicit CheckCall(const HealthService& service) : service_(service) {}
  void OnDone() override { delete this; }

 private:
  void OnRequest(bool is_known) override {
    if (!is_known) return Finish({grpc::StatusCode::NOT_FOUND, "unknown service"});
    response_ = ResponseOf(StatusOf(service_.is_serving()));
    StartWriteAndFinish(&response_, {}, grpc::Status::OK);
  }

  const HealthService& service_;
  grpc::ByteBuffer response_;
};

// gRPC may call the reactor while an operation is started, so no lock is held then. At most one
// write is under way, and Finish follows the last one.
class HealthService::WatchCall final : public Call, public std::enable_shared_from_this<WatchCall> {
 public:
  static grpc::ServerGenericBidiReactor* Make(HealthService& service) {
    const auto call = std::make_shared<WatchCall>(service);
    // ThreadSanitizer does not see that gRPC calls OnCancel after this. The lock shows it.
    const std::lock_guard lock(call->mutex_);
    call->self_ = call;
    return call.get();
  }
  explicit WatchCall(HealthService& service) : service_(service) {}
  // The last reference may be that of Set on another thread. The lock makes all writes visible
  // there.
  ~WatchCall() override { const std::lock_guard lock(mutex_); }

  // Sends the health; with `is_last`, ends the call after it.
  void Send(ServingStatus health, bool is_last = false) {
    {
      const std::lock_guard lock(mutex_);
      next_ = health;
      is_last_ = is_last_ || is_last;
      if (is_writing_ || end_) return;
      is_writing_ = true;
    }
    WriteNext();
  }
  void OnWriteDone(bool ok) override {
    bool goes_on = false;
    {
      const std::lock_guard lock(mutex_);
      if (!ok && !end_) end_ = grpc::Status::CANCELLED;
      if (is_last_ && !next_ && !end_) end_ = {grpc::StatusCode::UNAVAILABLE, "the daemon ends"};
      goes_on = is_writing_ = next_ && !end_;
      if (!goes_on && !end_) return;
    }
    goes_on ? WriteNext() : FinishOnce();
  }
  void OnCancel() override { End(grpc::Status::CANCELLED); }
  void OnDone() override {
    service_.Remove(shared_from_this());
    self_.reset();
  }

 private:
  void OnRequest(bool is_known) override {
    if (!is_known) return Send(ServingStatus::kServiceUnknown);
    if (!service_.Add(shared_from_this()))
      return End({grpc::StatusCode::RESOURCE_EXHAUSTED, "too many health watches; use Check"});
    // The health may change until Send has returned.
    bool is_serving = service_.is_serving();
    Send(StatusOf(is_serving));
    while (service_.is_serving() != is_serving) {
      is_serving = !is_serving;
      Send(StatusOf(is_serving));
    }
  }
  void WriteNext() {
    {
      const std::lock_guard lock(mutex_);
      response_ = ResponseOf(*std::exchange(next_, std::nullopt));
    }
    StartWrite(&response_);
  }
  void End(grpc::Status status) override {
    {
      const std::lock_guard lock(mutex_);
      if (!end_) end_ = std::move(status);
      if (is_writing_) return;
    }
    FinishOnce();
  }
  void FinishOnce() {
    grpc::Status end;
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(is_finished_, true)) return;
      end = *end_;
    }
    Finish(end);
  }

  HealthService& service_;
  std::shared_ptr<WatchCall> self_;  // until OnDone
  grpc::ByteBuffer response_;
  std::mutex mutex_;  // guards the members below
  std::optional<ServingStatus> next_;
  std::optional<grpc::Status> end_;
  bool is_last_ = false;  // the call ends after next_
  bool is_writing_ = false;
  bool is_finished_ = false;
};

grpc::ServerGenericBidiReactor* HealthService::Serve(std::string_view path) {
  if (path == kCheck) return new CheckCall(*this);
  return path == kWatch ? WatchCall::Make(*this) : nullptr;
}

bool HealthService::is_serving() const {
  const std::lock_guard lock(mutex_);
  return is_serving_;
}

bool HealthService::Add(const std::shared_ptr<WatchCall>& watch) {
  const std::lock_guard lock(mutex_);
  return watches_.size() < kMaxWatches && watches_.insert(watch).second;
}

void HealthService::Remove(const std::shared_ptr<WatchCall>& watch) {
  const std::lock_guard lock(mutex_);
  watches_.erase(watch);
}

void HealthService::Set(bool is_serving) {
  std::set<std::shared_ptr<WatchCall>> watches;
  bool is_last = false;
  {
    const std::lock_guard lock(mutex_);
    is_serving_ = is_serving && !is_down_;
    watches = watches_;
    is_serving = is_serving_;
    is_last = is_down_;
  }
  for (const std::shared_ptr<WatchCall>& watch : watches)
    watch->Send(StatusOf(is_serving), is_last);
}

void HealthService::ShutDown() {
  {
    const std::lock_guard lock(mutex_);
    is_down_ = true;
  }
  Set(false);
}

}  // namespace sweepstake::rpc
