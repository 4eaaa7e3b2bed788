// Hashes that give the same bits on every platform: splitmix64's mix for numbers, FNV-1a for bytes.
//
// Pure functions, safe from any thread. Not for secrets.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::math {

// 2^64 / golden ratio, the increment of splitmix64's state (G. Steele, D. Lea, C. Flood, "Fast
// splittable pseudorandom number generators", OOPSLA 2014). Its multiples modulo 2^64 fill the
// range evenly however many of them are taken.
inline constexpr uint64_t kGoldenGamma = 0x9E3779B97F4A7C15U;

// The output function of splitmix64: every input bit reaches every output bit.
constexpr uint64_t Mix64(uint64_t word) {
  word = (word ^ (word >> 30U)) * 0xBF58476D1CE4E5B9U;
  word = (word ^ (word >> 27U)) * 0x94D049BB133111EBU;
  return word ^ (word >> 31U);
}

// The generator splitmix64. The same state gives the same numbers on every platform.
struct SplitMix64 {
  uint64_t state;
  constexpr uint64_t Next() { return Mix64(state += kGoldenGamma); }
};

// FNV-1a with 64 bits. A hash begins with kFnv1aStart; its bytes may be added in any number of
// calls.
inline constexpr uint64_t kFnv1aStart = 0xCBF29CE484222325U;
inline constexpr uint64_t kFnv1aPrime = 0x100000001B3U;

constexpr uint64_t Fnv1a(uint64_t hash, uint8_t byte) { return (hash ^ byte) * kFnv1aPrime; }

constexpr uint64_t Fnv1a(uint64_t hash, std::string_view bytes) {
  for (const char byte : bytes) hash = Fnv1a(hash, static_cast<uint8_t>(byte));
  return hash;
}

// Returns the hash as 16 hexadecimal digits.
inline std::string HexOf(uint64_t hash) {
  std::string digits;
  for (int shift = 60; shift >= 0; shift -= 4) digits += "0123456789abcdef"[hash >> shift & 15];
  return digits;
}

// Adds the four bytes of `word` to the hash, the lowest byte first.
constexpr uint64_t Fnv1aOfWord(uint64_t hash, uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8)
    hash = Fnv1a(hash, static_cast<uint8_t>(word >> shift));
  return hash;
}

}  // namespace sweepstake::math
