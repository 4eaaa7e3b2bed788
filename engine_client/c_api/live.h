// The object behind a C handle. The object is small and stores whether its content lives. _destroy
// frees the content, and so does swp_shutdown_all for a host that has lost its handles. After
// swp_shutdown_all the object itself stays, so that a later use of the handle fails with an error
// instead of accessing freed memory.
//
// Thread safety: a call that may change the object counts itself in, so that swp_shutdown_all frees
// nothing under it. That takes two atomic additions and no lock. A call of a const object only
// checks whether the content lives; it may run beside other const calls, but not beside
// swp_shutdown_all. Objects are made and destroyed under one lock. Apart from that only
// swp_live_count, swp_last_error_of and swp_shutdown_all take this lock.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>

#include "engine_client/c_api/boundary.h"

namespace sweepstake::c_api {

class LiveObject {
 public:
  explicit LiveObject(swp_kind kind) : kind_(kind) {}
  virtual ~LiveObject() = default;
  LiveObject(const LiveObject&) = delete;
  LiveObject& operator=(const LiveObject&) = delete;

  swp_kind kind() const { return kind_; }
  bool has_ended() const noexcept { return ended_; }

  // Returns false if the content was freed or is about to be. Otherwise it stays alive until Leave.
  bool Enter() noexcept {
    ++call_count_;
    if (!ended_) return true;
    Leave();
    return false;
  }
  void Leave() noexcept { --call_count_; }

  // Stores this thread's latest failure as that of the object.
  void KeepError() const noexcept;

 private:
  friend class Registry;

  virtual bool has_content() const noexcept = 0;
  virtual void FreeContent() noexcept = 0;

  const swp_kind kind_;
  // Sequentially consistent with call_count_: either a call sees that the object has ended, or
  // swp_shutdown_all sees the call.
  std::atomic<bool> ended_ = false;
  std::atomic<uint32_t> call_count_ = 0;
  mutable std::atomic_flag writing_error_ = {};
  mutable std::array<char, 256> last_error_{};
  // Guarded by the lock of the registry.
  LiveObject* next_ = nullptr;
  LiveObject* previous_ = nullptr;
};

// The type of every handle: swp_world is Handle<World>, and so on.
template <typename ContentType>
class Handle : public LiveObject {
 public:
  using Content = ContentType;
  explicit Handle(std::unique_ptr<Content> made)
      : LiveObject(Content::kKind), content(std::move(made)) {}

  std::unique_ptr<Content> content;

 private:
  bool has_content() const noexcept override { return content != nullptr; }
  void FreeContent() noexcept override { content.reset(); }
};

void Register(LiveObject& object) noexcept;
void Unregister(LiveObject& object) noexcept;

// Fails with "swp_shutdown_all has ended this NAME: …", and stores the message in the object.
swp_result Ended(const LiveObject& object, std::string_view name) noexcept;

// Passes the ownership of `content` to the caller, as a new object.
template <typename Object, typename Content>
void Publish(std::unique_ptr<Content> content, Object** object) {
  auto made = std::make_unique<Object>(std::move(content));
  Register(*made);
  *object = made.release();
}

template <typename Object>
void Destroy(Object* object) noexcept {
  if (object == nullptr) return;
  Unregister(*object);
  delete object;
}

// Runs `body` with the content, converts exceptions into results, and stores a failure in the
// object. A body that returns nothing succeeds.
template <typename Object, typename Content, typename Body>
swp_result RunWith(const Object& object, Content& content, const Body& body) noexcept {
  const swp_result result = Guard([&] {
    if constexpr (std::is_void_v<decltype(body(content))>) {
      body(content);
      return swp_result{SWP_OK};
    } else {
      return swp_result{body(content)};
    }
  });
  if (result != SWP_OK) object.KeepError();
  return result;
}

// The common part of every function with a handle: refuses NULL and an object that has ended, then
// runs `body`.
template <typename Object, typename Body>
swp_result Use(Object* object, const Body& body) noexcept {
  using Content = typename Object::Content;
  if (object == nullptr) return NullArgument(Content::kName);
  if constexpr (std::is_const_v<Object>) {
    if (object->has_ended()) return Ended(*object, Content::kName);
    return RunWith(*object, std::as_const(*object->content), body);
  } else {
    if (!object->Enter()) return Ended(*object, Content::kName);
    const swp_result result = RunWith(*object, *object->content, body);
    object->Leave();
    return result;
  }
}

// Reads a value of the content into `*out`, which an error calls `name`.
template <typename Object, typename Value, typename Read>
swp_result Get(const Object* object, std::string_view name, Value* out, const Read& read) noexcept {
  return Use(object, [&](const auto& live) {
    if (out == nullptr) return NullArgument(name);
    *out = static_cast<Value>(read(live));
    return kOk;
  });
}

}  // namespace sweepstake::c_api
