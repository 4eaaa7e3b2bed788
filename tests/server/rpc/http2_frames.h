// The bytes of HTTP/2 (RFC 9113), so that tests can send what no regular client sends.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::test_support {

enum class Http2Type : char {
  kData = 0,
  kHeaders = 1,
  kResetStream = 3,
  kSettings = 4,
  kPing = 6,
  kGoAway = 7,
  kWindowUpdate = 8,
  kContinuation = 9
};

inline std::string Http2Frame(Http2Type type, char flags, uint32_t stream,
                              std::string_view payload) {
  std::string frame;
  for (const int shift : {16, 8, 0}) frame += static_cast<char>(payload.size() >> shift);
  frame += static_cast<char>(type);
  frame += flags;
  for (const int shift : {24, 16, 8, 0}) frame += static_cast<char>(stream >> shift);
  return frame.append(payload);
}

// Returns the first bytes of a client: the preface and empty settings.
inline std::string Http2Preface() {
  return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Http2Frame(Http2Type::kSettings, 0, 0, "");
}

// Returns the headers that begin a call of the method, uncompressed.
inline std::string Http2Call(uint32_t stream, std::string_view method) {
  constexpr char kEndOfHeaders = 4;
  std::string block;
  const auto add = [&block](std::string_view name, std::string_view value) {
    block += '\0';
    block.append(1, static_cast<char>(name.size())).append(name);
    block.append(1, static_cast<char>(value.size())).append(value);
  };
  add(":method", "POST");
  add(":scheme", "http");
  add(":path", method);
  add(":authority", "localhost");
  add("te", "trailers");
  add("content-type", "application/grpc");
  return Http2Frame(Http2Type::kHeaders, kEndOfHeaders, stream, block);
}

inline std::string Http2Reset(uint32_t stream) {
  constexpr std::string_view kCancel("\0\0\0\x08", 4);
  return Http2Frame(Http2Type::kResetStream, 0, stream, kCancel);
}

}  // namespace sweepstake::test_support
