#include "engine_client/c_api/live.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>

namespace sweepstake::c_api {

// The list of all objects of the process. It is the library's only global state. swp_shutdown_all
// needs it for hosts that have lost their handles.
class Registry {
 public:
  void Add(LiveObject& object) noexcept {
    const std::lock_guard lock(mutex_);
    object.next_ = first_;
    if (first_ != nullptr) first_->previous_ = &object;
    first_ = &object;
  }

  void Remove(LiveObject& object) noexcept {
    const std::lock_guard lock(mutex_);
    (object.previous_ == nullptr ? first_ : object.previous_->next_) = object.next_;
    if (object.next_ != nullptr) object.next_->previous_ = object.previous_;
  }

  uint32_t LiveCount(swp_kind kind) noexcept {
    const std::lock_guard lock(mutex_);
    uint32_t count = 0;
    for (const LiveObject* object = first_; object != nullptr; object = object->next_) {
      const bool counts = kind == SWP_KIND_ANY || kind == object->kind_;
      count += static_cast<uint32_t>(counts && object->has_content());
    }
    return count;
  }

  // Marks all objects as ended, so that no new call of them begins.
  void EndAll() noexcept {
    const std::lock_guard lock(mutex_);
    for (LiveObject* object = first_; object != nullptr; object = object->next_) {
      object->ended_ = true;
    }
  }

  enum class Freed { kOne, kNoneLeft, kOthersInCalls };

  // Frees the content of one object that has ended and has no call in progress.
  Freed FreeOne() noexcept {
    const std::lock_guard lock(mutex_);
    Freed freed = Freed::kNoneLeft;
    for (LiveObject* object = first_; object != nullptr; object = object->next_) {
      if (!object->ended_ || !object->has_content()) continue;
      freed = Freed::kOthersInCalls;
      if (object->call_count_ > 0) continue;
      object->FreeContent();
      return Freed::kOne;
    }
    return freed;
  }

  // Copies the object's latest failure to `text`. Returns false if no object has the address
  // `handle`.
  bool ErrorOf(const void* handle, char* text, uint32_t capacity) noexcept {
    const std::lock_guard lock(mutex_);
    const LiveObject* object = first_;
    while (object != nullptr && object != handle) object = object->next_;
    if (object == nullptr) return false;
    while (object->writing_error_.test_and_set()) std::this_thread::yield();
    const size_t length = std::min<size_t>(std::strlen(object->last_error_.data()), capacity - 1);
    std::copy_n(object->last_error_.data(), length, text);
    text[length] = '\0';
    object->writing_error_.clear();
    return true;
  }

 private:
  std::mutex mutex_;
  LiveObject* first_ = nullptr;  // newest first: an object is freed before those that it uses
};

namespace {

Registry registry;

}  // namespace

void Register(LiveObject& object) noexcept { registry.Add(object); }
void Unregister(LiveObject& object) noexcept { registry.Remove(object); }

// Stores the thread's latest failure in the object too. If another call is storing a failure in it,
// or a reader is copying one, it does not wait: the failure is then stored for the thread only.
void LiveObject::KeepError() const noexcept {
  if (writing_error_.test_and_set()) return;
  const char* const message = swp_last_error();
  const size_t length = std::min(std::strlen(message), last_error_.size() - 1);
  std::copy_n(message, length, last_error_.data());
  last_error_[length] = '\0';
  writing_error_.clear();
}

swp_result Ended(const LiveObject& object, std::string_view name) noexcept {
  std::array<char, 128> message;
  std::snprintf(message.data(), message.size(),
                "swp_shutdown_all has ended this %.*s: destroy it and make another",
                static_cast<int>(name.size()), name.data());
  const swp_result result = Fail(SWP_FAILED_PRECONDITION, message.data());
  object.KeepError();
  return result;
}

}  // namespace sweepstake::c_api

using sweepstake::c_api::Registry;
using sweepstake::c_api::registry;

uint32_t swp_live_count(swp_kind kind) { return registry.LiveCount(kind); }

swp_result swp_shutdown_all(uint32_t deadline_ms) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point deadline = Clock::now() + std::chrono::milliseconds(deadline_ms);
  registry.EndAll();
  for (;;) {
    const Registry::Freed freed = registry.FreeOne();
    if (freed == Registry::Freed::kOne) continue;
    if (freed == Registry::Freed::kNoneLeft) return SWP_OK;
    if (Clock::now() >= deadline) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return sweepstake::c_api::Fail(
      SWP_UNAVAILABLE, "calls are still in progress: wait for their return, then shut down again");
}

swp_result swp_last_error_of(const void* object, char* text, uint32_t capacity) {
  using sweepstake::c_api::Fail;
  if (object == nullptr || text == nullptr) {
    return sweepstake::c_api::NullArgument("object and text");
  }
  if (capacity == 0) return Fail(SWP_INVALID_ARGUMENT, "capacity must be at least 1, for the NUL");
  if (registry.ErrorOf(object, text, capacity)) return SWP_OK;
  return Fail(SWP_NOT_FOUND, "no object has this handle: it was destroyed, or never existed");
}
