// The object behind a C handle. The object is small and has a pointer to its content. _destroy
// frees both. For a host that has lost its handles, swp_shutdown_all frees the content of every
// object. The objects themselves stay, so that a later use of a handle fails with an error instead
// of accessing freed memory.
//
// Thread safety: a call that may change the object is counted while it runs, so that
// swp_shutdown_all frees no content in use. Counting takes two atomic additions and no lock. A call
// that takes the object as const only checks whether the content exists. It may run at the same
// time as other const calls, but not during swp_shutdown_all. One lock protects the list of
// objects. _create, _destroy, swp_live_count, swp_last_error_of and swp_shutdown_all take it; no
// other function does.
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

  // Begins a call. Returns true if the content exists; it is not freed before Leave. Returns false
  // if the content was freed or is about to be freed.
  bool Enter() noexcept {
    ++call_count_;
    if (!ended_) return true;
    Leave();
    return false;
  }
  void Leave() noexcept { --call_count_; }

  // Stores this thread's latest failure as the object's latest failure too.
  void KeepError() const noexcept;

 private:
  friend class Registry;

  virtual bool has_content() const noexcept = 0;
  virtual void FreeContent() noexcept = 0;

  const swp_kind kind_;
  // Both atomics are sequentially consistent. So either a new call sees that the object has ended,
  // or swp_shutdown_all sees that the call is in progress.
  std::atomic<bool> ended_ = false;
  std::atomic<uint32_t> call_count_ = 0;
  mutable std::atomic_flag writing_error_ = {};
  mutable std::array<char, 256> last_error_{};
  // Guarded by the lock of the registry.
  LiveObject* next_ = nullptr;
  LiveObject* previous_ = nullptr;
};

// The type of every handle. For example, swp_world is derived from Handle<World>.
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

// Fails with "swp_shutdown_all has ended this NAME: …", and stores that message in the object.
swp_result Ended(const LiveObject& object, std::string_view name) noexcept;

// Makes a new object with `content`, which the caller of the C ABI owns from then on, and sets
// `*object` to it.
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

// Runs `body` with the content. An exception becomes a failure, and a failure is stored in the
// object. A body without a result succeeds.
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

// Does what every function with a handle needs: fails for NULL and for an object that has ended,
// otherwise runs `body` with the content.
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

// Writes read(content) to `*out`. If `out` is NULL, the error calls it `name`.
template <typename Object, typename Value, typename Read>
swp_result Get(const Object* object, std::string_view name, Value* out, const Read& read) noexcept {
  return Use(object, [&](const auto& live) {
    if (out == nullptr) return NullArgument(name);
    *out = static_cast<Value>(read(live));
    return kOk;
  });
}

}  // namespace sweepstake::c_api
