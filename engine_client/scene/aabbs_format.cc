#include "engine_client/scene/aabbs_format.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "engine_client/text/names.h"

namespace sweepstake::aabbs {
namespace {

constexpr size_t kSceneNameAt = 0;
constexpr size_t kObjectTypeAt = 128;
constexpr size_t kObjectCountAt = 256;
constexpr size_t kFrameCountAt = 260;
constexpr size_t kLayoutAt = 264;
constexpr size_t kNotesBytesAt = 268;
constexpr size_t kWorldAt = 272;

using ConstBytes = std::span<const std::byte>;

Status Broken(std::string message) { return {StatusCode::kDataLoss, std::move(message)}; }

bool IsPrintable(char c) { return c >= 0x20 && c <= 0x7E; }

int32_t Int32At(const HeaderBytes& bytes, size_t offset) {
  return DecodeInt32(std::span(bytes).subspan(offset).first<kCountBytes>());
}

void PutInt32(int32_t value, size_t offset, HeaderBytes& bytes) {
  EncodeInt32(value, std::span(bytes).subspan(offset).first<kCountBytes>());
}

void PutText(std::string_view text, size_t offset, HeaderBytes& bytes) {
  const std::string clean = text::PrintableLine(text.substr(0, kNameBytes - 1));
  std::memcpy(bytes.data() + offset, clean.data(), clean.size());
}

Result<std::string> TextAt(const HeaderBytes& bytes, size_t offset, const std::string& field) {
  const char* first = reinterpret_cast<const char*>(bytes.data()) + offset;
  const char* end = std::find(first, first + kNameBytes, '\0');
  if (end == first + kNameBytes)
    return Broken("the " + field + " does not end with a zero byte within 128 bytes");
  if (!std::all_of(first, end, IsPrintable)) {
    return Broken("the " + field + " is not printable ASCII text");
  }
  return std::string(first, end);
}

Status CheckCounts(int32_t object_count, int32_t frame_count) {
  if (object_count <= 0) {
    return Broken("the object count is " + std::to_string(object_count) +
                  ", but must be at least 1");
  }
  if (frame_count < 0) {
    return Broken("the frame count is " + std::to_string(frame_count) + ", but must be at least 0");
  }
  return {};
}

Status CheckLayout(int32_t layout, int32_t notes_bytes) {
  if (layout != 0 && layout != 1) {
    return Broken("the layout flag at byte 264 is " + std::to_string(layout) +
                  ", but must be 0 or 1");
  }
  if (notes_bytes < 0 || notes_bytes > kMaxNotesBytes) {
    return Broken("the size of the notes at byte 268 is " + std::to_string(notes_bytes) +
                  ", but must be from 0 to " + std::to_string(kMaxNotesBytes));
  }
  return {};
}

Status CheckWorld(const Aabb& world) {
  if (!IsFinite(world)) return Broken("the world bounds are not finite");
  if (!IsValid(world)) return Broken("the world bounds are inverted (min > max)");
  return {};
}

float DecodeFloat(ConstBytes bytes, size_t index) {
  return std::bit_cast<float>(DecodeInt32(bytes.subspan(index * 4).first<kCountBytes>()));
}

void EncodeFloat(float value, size_t index, std::span<std::byte> bytes) {
  EncodeInt32(std::bit_cast<int32_t>(value), bytes.subspan(index * 4).first<kCountBytes>());
}

}  // namespace

HeaderBytes EncodeHeader(const Header& header) {
  HeaderBytes bytes{};
  PutText(header.scene_name, kSceneNameAt, bytes);
  PutText("AABB", kObjectTypeAt, bytes);
  PutInt32(header.object_count, kObjectCountAt, bytes);
  PutInt32(header.frame_count, kFrameCountAt, bytes);
  PutInt32(static_cast<int32_t>(header.layout), kLayoutAt, bytes);
  PutInt32(header.notes_bytes, kNotesBytesAt, bytes);
  EncodeBox(header.world, std::span(bytes).subspan<kWorldAt, kBoxBytes>());
  return bytes;
}

Result<Header> DecodeHeader(const HeaderBytes& bytes) {
  Header header;
  Result<std::string> name = TextAt(bytes, kSceneNameAt, "scene name");
  if (!name.ok()) return name.status();
  if (Result<std::string> type = TextAt(bytes, kObjectTypeAt, "object type"); !type.ok()) {
    return type.status();
  }
  header.scene_name = std::move(*name);
  header.object_count = Int32At(bytes, kObjectCountAt);
  header.frame_count = Int32At(bytes, kFrameCountAt);
  header.world = DecodeBox(std::span(bytes).subspan<kWorldAt, kBoxBytes>());
  const int32_t layout = Int32At(bytes, kLayoutAt);
  for (const Status& status :
       {CheckCounts(header.object_count, header.frame_count),
        CheckLayout(layout, Int32At(bytes, kNotesBytesAt)), CheckWorld(header.world)}) {
    if (!status.ok()) return status;
  }
  header.layout = static_cast<Layout>(layout);
  header.notes_bytes = Int32At(bytes, kNotesBytesAt);
  return header;
}

void EncodeBox(const Aabb& box, std::span<std::byte, kBoxBytes> bytes) {
  for (size_t axis = 0; axis < 3; ++axis) {
    EncodeFloat(box.min[axis], axis, bytes);
    EncodeFloat(box.max[axis], 4 + axis, bytes);
  }
  EncodeFloat(0, 3, bytes);
  EncodeFloat(0, 7, bytes);
}

Aabb DecodeBox(std::span<const std::byte, kBoxBytes> bytes) {
  Aabb box;
  for (size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = DecodeFloat(bytes, axis);
    box.max[axis] = DecodeFloat(bytes, 4 + axis);
  }
  return box;
}

void EncodeInt32(int32_t value, std::span<std::byte, kCountBytes> bytes) {
  const uint32_t bits = static_cast<uint32_t>(value);
  for (size_t i = 0; i < kCountBytes; ++i) bytes[i] = static_cast<std::byte>(bits >> (8 * i));
}

int32_t DecodeInt32(std::span<const std::byte, kCountBytes> bytes) {
  uint32_t bits = 0;
  for (size_t i = 0; i < kCountBytes; ++i) bits |= std::to_integer<uint32_t>(bytes[i]) << (8 * i);
  return static_cast<int32_t>(bits);
}

bool IsFinite(const Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(box.min[axis]) || !std::isfinite(box.max[axis])) return false;
  }
  return true;
}

}  // namespace sweepstake::aabbs
