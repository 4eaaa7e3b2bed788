// Checks whether a text is valid as a name, and makes error texts for names that are not in a list.
//
// Pure functions, safe from any thread.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace sweepstake::text {

inline constexpr size_t kMaxNameBytes = 128;

// Returns whether the text is valid as a name in messages, files and stores: 1 to kMaxNameBytes
// bytes of UTF-8 without control characters.
bool IsName(std::string_view text);
// Returns whether the text is empty or valid as a name (IsName).
bool IsOptionalName(std::string_view text);

// Returns whether the text is UTF-8 without control characters, of any length.
bool IsLine(std::string_view text);

// Returns `text` for use in a one-line message: each byte that is not printable ASCII becomes '?',
// and only the first 200 bytes are kept.
std::string PrintableLine(std::string_view text);

// Returns `text`, which can contain any bytes, for output on a terminal: each byte that is not part
// of a printable character in UTF-8, or of a line break, becomes '?'.
std::string PrintableLines(std::string_view text);

// Returns the valid name nearest to `name` by edit distance (Levenshtein), the first if several are
// equally near; empty if there is no valid name. Cost: the product of both lengths per valid name.
std::string_view NearestName(std::string_view name, std::span<const std::string_view> valid);

// Returns "unknown KIND 'NAME', must be one of A, B, C": A is the nearest name, and the others
// follow in the order of `valid`.
std::string UnknownName(std::string_view kind, std::string_view name,
                        std::span<const std::string_view> valid);

// Returns the error text for a list that is too long to read: "unknown KIND 'NAME', the nearest is
// A; --help lists all". It lists up to three names that are equally near, in the order of `valid`.
std::string UnknownNameOfMany(std::string_view kind, std::string_view name,
                              std::span<const std::string_view> valid);

}  // namespace sweepstake::text
